/* What `pinch run` shows of hands and of further objects. */
#include "pinch_run.h"

#include "common/output.h"
#include "common/terminal.h"
#include "hands/hand.h"
#include "scenes/world/world_hand.h"

#include <math.h>

/* ---- The table. ---- */

void run_print_joints(const world *w, FILE *stream)
{
    for (int k = 0; k < w->hand_count; k++) {
        terminal_print(stream, "  %-24s %12s %12s %12s %12s\n", "joint", "position", "speed", "target", "torque");
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *j = &w->hands[k].joints[i];
            terminal_print(stream, "  %-24s %12.6f %12.3g", j->name, j->position, j->velocity);
            if (j->control->type == SCENE_UNDRIVEN)
                terminal_print(stream, " %12s", "-");
            else
                terminal_print(stream, " %12.6f", j->target);
            terminal_print(stream, " %12.6f%s%s\n", j->torque, j->at_limit ? "  at its limit" : "",
                           j->saturated ? "  saturated" : "");
        }
    }
}

/* ---- The CSV file. ---- */

void run_hands_csv_header(const world *w, FILE *stream)
{
    static const char *const joint[] = {".position", ".velocity", ".torque", ".at_limit", ".saturated"};
    static const char *const object[] = {".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"};
    for (int k = 0; k < w->hand_count; k++)
        for (int i = 0; i < w->hands[k].joint_count; i++)
            for (size_t c = 0; c < sizeof joint / sizeof *joint; c++) {
                fputc(',', stream);
                csv_text(w->hands[k].joints[i].name, joint[c], stream);
            }
    for (int k = 1; k < w->object_count; k++)
        for (size_t c = 0; c < sizeof object / sizeof *object; c++) {
            fputc(',', stream);
            csv_text(w->scene->objects[k].name, object[c], stream);
        }
}

void run_hands_csv_row(const world *w, FILE *stream)
{
    for (int k = 0; k < w->hand_count; k++)
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *j = &w->hands[k].joints[i];
            csv_numbers(stream, (double[]){j->position, j->velocity, j->torque, j->at_limit, j->saturated}, 5);
        }
    for (int k = 1; k < w->object_count; k++) {
        csv_numbers(stream, dBodyGetPosition(w->objects[k].body), 3);
        csv_numbers(stream, dBodyGetQuaternion(w->objects[k].body), 4);
    }
}
