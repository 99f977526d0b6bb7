/* The report of a study: a picture that is pressed is played. */
"use strict";

if (document.querySelector("main.study")) {
    const films = JSON.parse(document.getElementById("films").textContent).films;
    const view = document.getElementById("view"), title = document.getElementById("view-title");
    for (const button of document.querySelectorAll("button[data-film]"))
        button.addEventListener("click", async () => {
            if (window.viewer instanceof Viewer) window.viewer.close();
            for (const other of document.querySelectorAll("button[data-film]"))
                other.toggleAttribute("aria-current", other === button);
            const film = films[Number(button.dataset.film)];
            title.textContent = film.title;
            window.viewer = await Viewer.open(view, film.film, film.ghost);
            window.viewer.seek(film.moment);
            title.scrollIntoView({ block: "start" });
        });
}
