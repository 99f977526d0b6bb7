/* A hand as tables. */

#include "listing.h"

#include "common/output.h"
#include "common/terminal.h"

static const char *link_name(const hand *h, int link)
{
    return link < 0 ? "(the hand's frame)" : h->links[link].name;
}

static size_t count_geoms(const hand *h, int link)
{
    size_t count = 0;
    for (size_t i = 0; i < h->geom_count; i++) count += h->geoms[i].collides && h->geoms[i].link == link;
    return count;
}

static void print_links(const hand *h, FILE *stream)
{
    terminal_print(stream, "  %-24s %-24s %12s %9s\n", "link", "body", "mass kg", "contacts");
    for (size_t i = 0; i < h->link_count; i++) {
        const hand_link *l = &h->links[i];
        terminal_print(stream, "  %-24s %-24s %12.6g %9zu\n", l->name, h->bodies[l->body].name, l->mass.mass,
                       count_geoms(h, (int)i));
    }
}

enum { RANGE = 100 };

static void print_range(double least, double most, char text[RANGE])
{
    char low[48], high[48];
    snprintf(text, RANGE, "%s to %s", number_for_people("%.6g", least, low), number_for_people("%.6g", most, high));
}

static void print_joints(const hand *h, FILE *stream)
{
    if (!h->joint_count) return;
    terminal_print(stream, "  %-24s %-7s %-24s %23s %10s %10s %10s %10s\n", "joint", "type", "moves", "limits (rad, m)",
                   "effort", "damping", "friction", "armature");
    for (size_t i = 0; i < h->joint_count; i++) {
        const hand_joint *j = &h->joints[i];
        char limits[RANGE] = "none", effort[48];
        if (j->limited) print_range(j->lower, j->upper, limits);
        /* what drives of different strength do both ways is in the JSON document */
        terminal_print(stream, "  %-24s %-7s %-24s %23s %s %10.4g %10.4g %10.4g\n", j->name,
                       j->type == HAND_HINGE ? "hinge" : "slider", h->links[j->link].name, limits,
                       number_for_people("%10.4g", j->effort, effort), j->damping, j->friction, j->armature);
    }
}

static void print_drives(const hand *h, FILE *stream)
{
    static const char *const types[] = {"position", "velocity", "motor", "affine"};
    if (!h->drive_count) return;
    terminal_print(stream, "  %-24s %-9s %-24s %10s %10s %10s %10s %23s\n", "drive", "type", "of", "gain", "constant",
                   "kp", "kd", "force");
    for (size_t i = 0; i < h->drive_count; i++) {
        const hand_drive *d = &h->drives[i];
        char force[RANGE] = "unlimited";
        if (isfinite(d->most_force) || isfinite(d->least_force)) print_range(d->least_force, d->most_force, force);
        terminal_print(stream, "  %-24s %-9s %-24s %10.4g %10.4g %10.4g %10.4g %23s\n", d->name, types[d->type],
                       d->joint >= 0 ? h->joints[d->joint].name : h->tendons[d->tendon].name, d->gain, d->bias[0],
                       d->kp, d->kd, force);
    }
}

static void print_couplings(const hand *h, FILE *stream)
{
    for (size_t i = 0; i < h->coupling_count; i++) {
        const hand_coupling *c = &h->couplings[i];
        if (c->of < 0)
            terminal_print(stream, "  coupling: %s = %.9g\n", h->joints[c->joint].name, c->offset);
        else
            terminal_print(stream, "  coupling: %s = %.9g + %.9g * %s\n", h->joints[c->joint].name, c->offset,
                           c->multiplier, h->joints[c->of].name);
    }
    for (size_t i = 0; i < h->tendon_count; i++) {
        const hand_tendon *t = &h->tendons[i];
        terminal_print(stream, "  tendon: %s =", t->name);
        for (size_t k = 0; k < t->count; k++)
            terminal_print(stream, "%s %.9g * %s", k ? " +" : "", t->coefficients[k], h->joints[t->joints[k]].name);
        fputc('\n', stream);
    }
    for (size_t i = 0; i < h->loop_count; i++)
        terminal_print(stream, "  loop: %s and %s stay together at a point\n", link_name(h, h->loops[i].link[0]),
                       link_name(h, h->loops[i].link[1]));
}

static void print_remarks(const char *title, const hand_remark *items, size_t count, FILE *stream)
{
    if (!count) return;
    terminal_print(stream, "  %s:", title);
    for (size_t i = 0; i < count; i++) {
        terminal_print(stream, "%s %s (line %d", i ? "," : "", items[i].what, items[i].line);
        if (items[i].count > 1) terminal_print(stream, " and %zu more", items[i].count - 1);
        fputc(')', stream);
    }
    fputc('\n', stream);
}

static void print_tips(const hand *h, FILE *stream)
{
    int count = 0;
    for (size_t b = 0; b < h->body_count; b++) {
        int tip = hand_tip_of(h, b);
        if (tip >= 0) terminal_print(stream, "%s %s", count++ ? "," : "  tips:", h->links[tip].name);
    }
    if (count > 0) fputc('\n', stream);
}

void hand_print(const hand *h, FILE *stream)
{
    terminal_print(stream, "%s: %s \"%s\": %zu links in %zu bodies, %zu joints, %zu drive%s, %.9g kg\n", h->file,
                   h->is_mjcf ? "MJCF" : "URDF", h->name, h->link_count, h->body_count, h->joint_count, h->drive_count,
                   h->drive_count == 1 ? "" : "s", hand_total_mass(h));
    print_links(h, stream);
    print_joints(h, stream);
    print_drives(h, stream);
    print_couplings(h, stream);
    print_tips(h, stream);
    if (h->exclude_count) terminal_print(stream, "  %zu pairs of links do not touch each other\n", h->exclude_count);
    print_remarks("ignored", h->ignored, h->ignored_count, stream);
    print_remarks("NOT MODELLED", h->unmodelled, h->unmodelled_count, stream);
}

void hand_print_poses(const hand *h, const hand_pose *poses, FILE *stream)
{
    terminal_print(stream, "  %-24s %38s %50s\n", "link", "position (m)", "orientation (w, x, y, z)");
    for (size_t i = 0; i < h->link_count; i++) {
        const hand_pose *p = &poses[i];
        terminal_print(stream, "  %-24s %12.9f %12.9f %12.9f %12.9f %12.9f %12.9f %12.9f\n", h->links[i].name,
                       p->position[0], p->position[1], p->position[2], p->orientation[0], p->orientation[1],
                       p->orientation[2], p->orientation[3]);
    }
}
