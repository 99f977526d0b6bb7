#include "statics/load_step.h"

#include <math.h>
#include <string.h>

static const size_t REST_SIZE = 3 * sizeof(double);

void pinch_static_save(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) memcpy(model->contacts[c].saved, model->contacts[c].rest, REST_SIZE);
}

void pinch_static_restore(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) memcpy(model->contacts[c].rest, model->contacts[c].saved, REST_SIZE);
}

/*
 * A load step is no jump: an equilibrium further away than ten thousand times what the softest spring gives under the
 * added load is another one than the path leads to.
 */
static bool follow(const pinch_static_phase *p, double part, const double *start, double *at)
{
    const double far = 1e4;
    double softest, stiffest, away = 0.0;
    pinch_static_stiffness_range(p->model, &softest, &stiffest);
    bool found = pinch_static_follow(p->model, &p->solver, start, at, p->total);
    for (int j = 0; j < p->model->freedoms; j++) away = hypot(away, at[j] - start[j]);
    return found && softest * away <= far * part;
}

/*
 * The equilibrium at `next` with the state at `done` in u: from where the last step's motion would lead, which keeps to
 * the branch the path is on, or from u itself.
 */
static bool settle_at(const pinch_static_phase *p, double done, double next, double *u)
{
    double at[6];
    *p->factor = p->goal * next;
    for (int j = 0; j < 6; j++) at[j] = u[j] + p->rate[j] * (next - done);
    bool settled = follow(p, next - done, u, at);
    if (!settled) {
        memcpy(at, u, sizeof at);
        settled = follow(p, next - done, u, at);
    }
    if (settled) memcpy(u, at, sizeof at);
    return settled;
}

/* By how much the springs' forces differ between the rest now and `coarse`; torsion counts over its lever. */
static double coarse_error(const pinch_static_model *model)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        for (int i = 1; i < contact->rows; i++)
            worst = fmax(worst, contact->k[i] * fabs(contact->rest[i - 1] - contact->coarse[i - 1]));
    }
    return worst;
}

/* The direction of friction (zero for none), and by how much the springs' forces exceed what it can be. */
static double friction(const pinch_static_model *model, const pinch_static_contact *contact, const double *u,
                       double direction[3])
{
    double s[4], r[4], size = 0.0, excess = 0.0;
    pinch_static_trial(model, contact, u, s);
    pinch_static_law(model, contact, s, r, NULL);
    for (int i = 0; i < 3; i++) {
        direction[i] = r[i + 1];
        size = hypot(size, r[i + 1]);
        excess = hypot(excess, s[i + 1] - r[i + 1]);
    }
    for (int i = 0; i < 3 && size > 0.0; i++) direction[i] /= size;
    return excess;
}

/* Notes at the middle of a step, before its slip is committed, who has stuck so far. */
static void note_onset(pinch_static_model *model, const double *middle)
{
    for (int c = 0; c < model->count; c++)
        model->contacts[c].stuck = friction(model, &model->contacts[c], middle, model->contacts[c].onset) == 0.0;
}

/*
 * A contact that sticks in the first half of a step and slips in the second slips by the same amount, in one direction,
 * in the one step and in the second half. What neither sees is how the force turned meanwhile.
 */
static double unseen_error(const pinch_static_model *model, const double *end)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        double direction[3], turn = 0.0;
        if (!contact->stuck) continue;
        double excess = friction(model, contact, end, direction);
        for (int i = 0; i < 3; i++) turn = hypot(turn, direction[i] - contact->onset[i]);
        worst = fmax(worst, 0.5 * excess * turn);
    }
    return worst;
}

/*
 * The slip of one step of backward Euler is wrong by c h^2 per step, that of two half steps by half as much: their
 * difference is the error of the better one, and adding it once more cancels it. What is reported at the end of a phase
 * is not extrapolated, so that it obeys the friction law to rounding.
 */
static void extrapolate(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        if (contact->open || contact->coarse_open) continue; /* no slip there: rest follows the object */
        for (int i = 0; i < 3; i++) contact->rest[i] += contact->rest[i] - contact->coarse[i];
    }
}

/* Keeps the rest after the step at once, to be compared with that of the halves, and goes back to the start. */
static void put_aside_coarse(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) {
        memcpy(model->contacts[c].coarse, model->contacts[c].rest, REST_SIZE);
        model->contacts[c].coarse_open = model->contacts[c].open;
    }
    pinch_static_restore(model);
}

/* The halves: u at the middle and at the end, the end's slip committed. */
static bool take_halves(const pinch_static_phase *p, double done, double next, double *middle, double *end,
                        double *unseen)
{
    double half = 0.5 * (done + next);
    memcpy(middle, p->u, 6 * sizeof *middle);
    if (!settle_at(p, done, half, middle)) return false;
    note_onset(p->model, middle);
    pinch_static_commit(p->model, middle);
    memcpy(end, middle, 6 * sizeof *end);
    if (!settle_at(p, half, next, end)) return false;
    *unseen = unseen_error(p->model, end);
    pinch_static_commit(p->model, end);
    return true;
}

bool pinch_static_load_step(const pinch_static_phase *p, double done, double next, bool last, double *error)
{
    pinch_static_model *model = p->model;
    double coarse[6], middle[6], end[6], unseen;
    *error = 0.0;
    memcpy(coarse, p->u, sizeof coarse);
    if (!settle_at(p, done, next, coarse)) return false;
    if (!(p->tolerance < INFINITY)) {
        memcpy(p->u, coarse, sizeof coarse);
        if (!last) pinch_static_commit(model, p->u);
        return true;
    }
    pinch_static_save(model);
    pinch_static_commit(model, coarse);
    put_aside_coarse(model);
    if (!take_halves(p, done, next, middle, end, &unseen)) {
        pinch_static_restore(model);
        return false;
    }
    *error = fmax(coarse_error(model), unseen);
    if (*error > p->tolerance) {
        pinch_static_restore(model);
        return false;
    }
    memcpy(p->u, end, sizeof end);
    if (!last) {
        extrapolate(model);
        return true;
    }
    /* the caller wants the rest before the last half: found again from the start and the middle's u */
    pinch_static_restore(model);
    *p->factor = p->goal * 0.5 * (done + next);
    pinch_static_commit(model, middle);
    *p->factor = p->goal * next;
    return true;
}
