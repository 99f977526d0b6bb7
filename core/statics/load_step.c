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

static double length3(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* By how much the springs' forces s exceed what friction r can be. */
static double excess(const double s[4], const double r[4])
{
    const double over[3] = {s[1] - r[1], s[2] - r[2], s[3] - r[3]};
    return length3(over);
}

/* Notes at the middle of a step, before its slip is committed, how every contact is. */
static void note_middle(pinch_static_model *model, const double *middle)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        pinch_static_trial(model, contact, middle, s);
        bool open = pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN;
        contact->gap = open && !contact->controlled ? -s[0] : 0.0;
        contact->stuck = !open && excess(s, r) == 0.0;
        memcpy(contact->onset, r + 1, sizeof contact->onset);
    }
}

/* What the force's turn since the middle changes in a slip that began after it and has the end's direction. */
static double turning_error(const pinch_static_contact *contact, const double s[4], const double r[4])
{
    double before = length3(contact->onset), after = length3(r + 1), turn[3];
    for (int i = 0; i < 3; i++)
        turn[i] = (after > 0.0 ? r[i + 1] / after : 0.0) - (before > 0.0 ? contact->onset[i] / before : 0.0);
    return 0.5 * excess(s, r) * length3(turn);
}

/* A contact that closes after the middle pulls from where it was then, not from where it touched. */
static double touching_error(const pinch_static_model *model, const pinch_static_contact *contact, const double s[4],
                             const double r[4])
{
    double part = s[0] / (s[0] + contact->gap), touched[4] = {s[0], part * s[1], part * s[2], part * s[3]}, other[4];
    pinch_static_law(model, contact, touched, other, NULL);
    const double wrong[3] = {other[1] - r[1], other[2] - r[2], other[3] - r[3]};
    return length3(wrong);
}

/* Notes at the start of a step how far open every contact is. */
static void note_start(pinch_static_model *model, const double *start)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        pinch_static_trial(model, contact, start, s);
        bool open = pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN;
        contact->gap = open && !contact->controlled ? -s[0] : 0.0;
    }
}

/* What neither the one step nor the halves see of contacts that close in the first half. */
static double closing_error(const pinch_static_model *model, const double *middle)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        if (contact->rows == 1 || contact->gap == 0.0) continue;
        pinch_static_trial(model, contact, middle, s);
        if (pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN) continue;
        worst = fmax(worst, touching_error(model, contact, s, r));
    }
    return worst;
}

/*
 * A contact that sticks or is open in the first half of a step and slips in the second may end up the same after the
 * one step and after the two halves. What neither sees is estimated from the state in the middle.
 */
static double unseen_error(const pinch_static_model *model, const double *end)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        if (contact->rows == 1 || (!contact->stuck && contact->gap == 0.0)) continue;
        pinch_static_trial(model, contact, end, s);
        if (pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN) continue;
        worst = fmax(worst, contact->stuck ? turning_error(contact, s, r) : touching_error(model, contact, s, r));
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
    *p->factor = p->goal * done;
    note_start(p->model, middle);
    if (!settle_at(p, done, half, middle)) return false;
    *unseen = closing_error(p->model, middle);
    note_middle(p->model, middle);
    pinch_static_commit(p->model, middle);
    memcpy(end, middle, 6 * sizeof *end);
    if (!settle_at(p, half, next, end)) return false;
    *unseen = fmax(*unseen, unseen_error(p->model, end));
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
