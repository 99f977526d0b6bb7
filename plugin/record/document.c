/* Writes a recording as a JSON document. */
#define _POSIX_C_SOURCE 200809L

#include <pinch/ode.h>

#include <inttypes.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>

/* As few digits as read back as the same bits. A zero with a sign needs a point: without one it would read as a whole
 * number, which has no sign. */
static void put_number(FILE *stream, double value)
{
    char text[32];
    if (!isfinite(value)) {
        fputs("null", stream);
        return;
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    fprintf(stream, "%s%s", text, value == 0 && signbit(value) ? ".0" : "");
}

static void put_list(FILE *stream, const double *values, int count)
{
    fputc('[', stream);
    for (int i = 0; i < count; i++) {
        if (i > 0) fputs(", ", stream);
        put_number(stream, values[i]);
    }
    fputc(']', stream);
}

static void put_member(FILE *stream, const char *key, double value)
{
    fprintf(stream, ", \"%s\": ", key);
    put_number(stream, value);
}

static void put_members(FILE *stream, const char *key, const double *values, int count)
{
    fprintf(stream, ", \"%s\": ", key);
    put_list(stream, values, count);
}

static void put_body(FILE *stream, const pinch_body *b)
{
    fputs("{\"mass\": ", stream);
    put_number(stream, b->mass);
    put_members(stream, "inertia", b->inertia, 9);
    put_members(stream, "position", b->position, 3);
    put_members(stream, "velocity", b->velocity, 6);
    put_members(stream, "external", b->external, 6);
    put_member(stream, "radius", b->radius);
    if (b->mass == 0) {
        put_members(stream, "drive_axis", b->drive_axis, 3);
        put_member(stream, "drive_force", b->drive_force);
    }
    fputc('}', stream);
}

static const char *model_name(pinch_contact_model model)
{
    switch (model) {
    case PINCH_CONTACT_FRICTIONLESS:
        return "frictionless";
    case PINCH_CONTACT_HARD:
        return "hard";
    case PINCH_CONTACT_SOFT:
        return "soft";
    default:
        return "rolling";
    }
}

static void put_contact(FILE *stream, const pinch_contact *c)
{
    fprintf(stream, "{\"bodies\": [%d, %d], \"model\": \"%s\"", c->body1, c->body2, model_name(c->model));
    put_members(stream, "position", c->position, 3);
    put_members(stream, "normal", c->normal, 3);
    put_members(stream, "tangent1", c->tangent1, 3);
    put_members(stream, "surface_velocity", c->surface_velocity, 6);
    put_member(stream, "depth", c->depth);
    put_members(stream, "stiffness", c->stiffness, 3);
    put_members(stream, "damping", c->damping, 3);
    put_members(stream, "elastic", c->elastic, 3);
    put_members(stream, "friction", c->friction, 2);
    put_member(stream, "torsional_friction", c->torsional_friction);
    put_members(stream, "rolling_friction", c->rolling_friction, 2);
    put_members(stream, "friction_limit", c->friction_limit, 5);
    put_members(stream, "viscous", c->viscous, 2);
    put_member(stream, "max_force", c->max_force);
    fprintf(stream, ", \"may_soften\": %s, \"hold\": %d, \"hold_span\": %d", c->may_soften ? "true" : "false", c->hold,
            c->hold_span);
    put_member(stream, "floor", c->floor);
    put_members(stream, "compliance", c->compliance, 3);
    put_members(stream, "rolling_elastic", c->rolling_elastic, 2);
    put_members(stream, "rolling_moment", c->rolling_moment, 2);
    put_members(stream, "force", c->force, 4);
    fputc('}', stream);
}

static void put_row(FILE *stream, const pinch_joint_row *row)
{
    fprintf(stream, "{\"bodies\": [%d, %d]", row->body1, row->body2);
    put_members(stream, "j1", row->j1, 6);
    put_members(stream, "j2", row->j2, 6);
    if (row->continues) fputs(", \"continues\": true", stream);
    put_member(stream, "rhs", row->rhs);
    put_member(stream, "cfm", row->cfm);
    put_member(stream, "yield", row->yield);
    put_member(stream, "low", row->low);
    put_member(stream, "high", row->high);
    put_member(stream, "force", row->force);
    fputc('}', stream);
}

/* Puts what is between the elements of a list that has a line for each. */
static void next_line(FILE *stream, int index)
{
    fputs(index > 0 ? ",\n      " : "\n      ", stream);
}

/* What was remembered of another island is not used. */
static void put_memory(FILE *stream, const pinch_problem *problem)
{
    pinch_step_factors f = {.unknowns = 0};
    if (problem->memory) f = pinch_step_memory_read(problem->memory);
    if (f.unknowns == 0 || f.tag != problem->tag) {
        fputs("null", stream);
        return;
    }
    fputs("{\"states\": [", stream);
    for (int i = 0; i < f.element_count; i++) fprintf(stream, "%s%d", i > 0 ? ", " : "", f.states[i]);
    fputs("], \"pivot\": [", stream);
    for (int i = 0; i < f.unknowns; i++) fprintf(stream, "%s%d", i > 0 ? ", " : "", f.pivot[i]);
    fputs("], \"factors\": ", stream);
    put_list(stream, f.lu, f.unknowns * f.unknowns);
    fputc('}', stream);
}

static void put_problem(FILE *stream, const pinch_problem *problem)
{
    fputs("  \"problem\": {\n    \"step\": ", stream);
    put_number(stream, problem->step);
    fprintf(stream, ",\n    \"faces\": %d,\n    \"bodies\": [", problem->faces);
    for (int i = 0; i < problem->body_count; i++) {
        next_line(stream, i);
        put_body(stream, &problem->bodies[i]);
    }
    fputs("],\n    \"contacts\": [", stream);
    for (int i = 0; i < problem->contact_count; i++) {
        next_line(stream, i);
        put_contact(stream, &problem->contacts[i]);
    }
    fputs("],\n    \"rows\": [", stream);
    for (int i = 0; i < problem->row_count; i++) {
        next_line(stream, i);
        put_row(stream, &problem->rows[i]);
    }
    fputs("],\n    \"memory\": ", stream);
    put_memory(stream, problem);
    fputs("\n  },\n", stream);
}

static void put_settings(FILE *stream, const pinch_solver_settings *s)
{
    fprintf(stream, "  \"solver\": {\"name\": \"%s\"", pinch_solver_name(s->solver));
    put_member(stream, "tolerance", s->tolerance);
    put_member(stream, "goal", s->goal);
    put_member(stream, "budget", s->budget);
    fprintf(stream, ", \"sweeps\": %d, \"sweeps_alone\": %s", s->sweeps, s->sweeps_alone ? "true" : "false");
    fprintf(stream, ", \"max_iterations\": %d, \"newton_finish\": %s, \"seed\": \"%" PRIu64 "\"},\n", s->max_iterations,
            s->newton_finish ? "true" : "false", s->seed);
}

static void put_ended(FILE *stream, const pinch_problem *ended, const pinch_step_result *result)
{
    fprintf(stream, "  \"ended\": {\"status\": \"%s\", \"iterations\": %d, \"newton_steps\": %d",
            pinch_solve_status_text(result->solve.status), result->solve.iterations, result->solve.newton_steps);
    put_member(stream, "residual", result->solve.residual);
    fputs(",\n    \"velocities\": [", stream);
    for (int i = 0; i < ended->body_count; i++) {
        next_line(stream, i);
        put_list(stream, ended->bodies[i].velocity_end, 6);
    }
    fputs("],\n    \"contact_forces\": [", stream);
    for (int i = 0; i < ended->contact_count; i++) {
        next_line(stream, i);
        put_list(stream, ended->contacts[i].force, 4);
    }
    fputs("],\n    \"row_forces\": [", stream);
    for (int i = 0; i < ended->row_count; i++) {
        if (i > 0) fputs(", ", stream);
        put_number(stream, ended->rows[i].force);
    }
    fputs("]\n  }\n", stream);
}

bool pinch_ode_write_recording(const pinch_ode_recording *recording, FILE *stream)
{
    /* the program may have a decimal comma */
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0) return false;
    locale_t own = uselocale(plain);
    fprintf(stream, "{\n  \"format\": \"pinch-island/1\",\n  \"step_number\": %ld,\n  \"island\": %d,\n",
            recording->step, recording->island);
    put_settings(stream, recording->settings);
    put_problem(stream, recording->problem);
    put_ended(stream, recording->ended, recording->result);
    fputs("}\n", stream);
    (void)uselocale(own);
    freelocale(plain);
    return !ferror(stream);
}
