#include "report_style.h"

/* Colours after Okabe and Ito's palette, darker on white and lighter on black so that lines keep a contrast of 3:1 and
 * text one of 4.5:1. */
static const char *const sheet[] = {
    ":root{--ink:#1b1f24;--dim:#57606a;--paper:#fff;--card:#f6f8fa;--rule:#d0d7de;--link:#0550ae;",
    "--s0:#0059b3;--s1:#c2410c;--s2:#9a6700;--s3:#a3357a;--s4:#0a7a55;--s5:#6639ba;--s6:#5c5f62;--s7:#006d77;",
    "--s8:#8a4b08;--s9:#b42318;--good:#dafbe1;--fair:#fff8c5;--bad:#ffe2dd;--shape:#d8dee4;--tip:#c8d7ea;",
    "color-scheme:light dark}\n",
    "@media (prefers-color-scheme:dark){:root{--ink:#e6edf3;--dim:#9da7b1;--paper:#0d1117;--card:#161b22;",
    "--rule:#3d444d;--link:#6cb6ff;--s0:#58a6ff;--s1:#ff8a5c;--s2:#e3b341;--s3:#f08bc4;--s4:#3fcf95;--s5:#b794f6;",
    "--s6:#b1bac4;--s7:#5fc9d4;--s8:#e0a36a;--s9:#ff7b72;--good:#12321f;--fair:#332a09;--bad:#42180f;",
    "--shape:#30363d;--tip:#26384f}}\n",
    "*{box-sizing:border-box}body{margin:0 auto;padding:1rem 1.5rem 3rem;max-width:78rem;color:var(--ink);",
    "background:var(--paper);font:16px/1.5 system-ui,'DejaVu Sans',sans-serif}\n",
    "h1{font-size:1.7rem;line-height:1.2;margin:.6rem 0}h2{font-size:1.35rem;margin:2.2rem 0 .4rem;padding-top:.6rem;",
    "border-top:2px solid var(--rule)}h3{font-size:1.05rem;margin:1.2rem 0 .3rem}p{max-width:60rem;margin:.5rem 0}\n",
    "a{color:var(--link)}.note{color:var(--dim);font-size:.9rem}.defs{position:absolute}\n",
    ".wide{overflow-x:auto;margin:.8rem 0}table{border-collapse:collapse;font-size:.88rem;",
    "font-variant-numeric:tabular-nums;width:100%}caption{text-align:left;color:var(--dim);padding:.3rem 0;",
    "font-size:.9rem}th,td{padding:.22rem .6rem;border-bottom:1px solid "
    "var(--rule);text-align:right;white-space:nowrap}",
    "th:first-child,td.text,.metrics th:nth-child(2){text-align:left}thead th{border-bottom:2px solid "
    "var(--rule);vertical-align:bottom}",
    "tbody th{font-weight:500}td.unit{color:var(--dim);text-align:left}sup{line-height:0}\n",
    "td.exact{background:var(--good)}td.close{background:var(--fair)}td.off,td.dropped{background:var(--bad)}\n",
    ".verdicts{list-style:none;padding:0;margin:.6rem 0}.verdicts li{margin:.2rem 0;padding-left:1.3rem;",
    "text-indent:-1.3rem}.key{display:inline-block;width:.8rem;height:.8rem;margin-right:.5rem;border-radius:2px;",
    "background:var(--c);vertical-align:-1px}.legend{white-space:nowrap;margin-left:.6rem}",
    ".swatch{width:30px;height:8px;margin-right:.3rem;vertical-align:middle}\n",
    ".figures{display:grid;grid-template-columns:repeat(auto-fill,minmax(19rem,1fr));gap:.9rem}",
    ".chart{margin:0;padding:.5rem .6rem;background:var(--card);border:1px solid var(--rule);border-radius:6px}",
    ".chart figcaption{font-size:.85rem;font-weight:600;margin-bottom:.2rem}.chart svg{display:block;width:100%;",
    "height:auto}svg text{font:11px system-ui,'DejaVu Sans',sans-serif;fill:var(--ink)}svg .mid{text-anchor:middle}",
    "svg .end{text-anchor:end}svg .power{font-size:8px}\n",
    ".grid{stroke:var(--rule);stroke-width:.7;fill:none}.frame{stroke:var(--dim);stroke-width:1;fill:none}",
    ".line{fill:none;stroke:var(--c);stroke-width:1.5;stroke-linejoin:round}.line.s0{stroke-width:2}",
    ".line.s1{stroke-dasharray:6 3}.line.s2{stroke-dasharray:2 2}.line.s3{stroke-dasharray:8 2 2 2}",
    ".line.s4{stroke-dasharray:10 4}.line.s5{stroke-dasharray:4 4}.bar{fill:var(--c)}\n",
    ".arrow{fill:none;stroke:var(--c);stroke-width:2.4}.arrow.s1{stroke-width:1.8;stroke-dasharray:5 3}",
    ".cone{fill:var(--s4);fill-opacity:.14;stroke:var(--s4);stroke-width:.8}.paper{fill:var(--paper)}",
    ".object{fill:var(--shape);fill-opacity:.7;stroke:var(--ink);stroke-width:1.2}.finger{fill:var(--tip);fill-opacity:"
    ".75;",
    "stroke:var(--dim);stroke-width:1}.environment{fill:var(--rule);fill-opacity:.5;stroke:var(--dim)}\n",
    ".s0{--c:var(--s0)}.s1{--c:var(--s1)}.s2{--c:var(--s2)}.s3{--c:var(--s3)}.s4{--c:var(--s4)}.s5{--c:var(--s5)}",
    ".s6{--c:var(--s6)}.s7{--c:var(--s7)}.s8{--c:var(--s8)}.s9{--c:var(--s9)}\n",
    "@media print{:root{--ink:#000;--dim:#444;--paper:#fff;--card:#fff;--rule:#bbb;--link:#000;--s0:#0059b3;",
    "--s1:#c2410c;--s2:#9a6700;--s3:#a3357a;--s4:#0a7a55;--s5:#6639ba;--good:#dafbe1;--fair:#fff8c5;--bad:#ffe2dd;",
    "--shape:#d8dee4;--tip:#c8d7ea;color-scheme:light}body{max-width:none;padding:0;font-size:10pt}",
    "section{break-before:page}section:first-of-type{break-before:auto}.chart,tr{break-inside:avoid}",
    "h2,h3{break-after:avoid}.figures{grid-template-columns:repeat(3,1fr);gap:.4rem}table{font-size:7.5pt}",
    "th,td{padding:.1rem .3rem}.wide{overflow:visible}*{-webkit-print-color-adjust:exact;print-color-adjust:exact}",
    ".chart figcaption{font-size:7.5pt}@page{margin:14mm}}\n",
};

void report_style(FILE *stream)
{
    for (size_t i = 0; i < sizeof sheet / sizeof *sheet; i++) fputs(sheet[i], stream);
}
