/* Remembers the factors of an island's last Jacobian from step to step. */
#include "velocity/velocity_system.h"

#include <stdlib.h>
#include <string.h>

unsigned char pinch_velocity_state_of(const pinch_velocity_system *vs, const pinch_element *element)
{
    const pinch_multiplier *multiplier = pinch_multiplier_of(vs, element);
    return (unsigned char)(multiplier ? PINCH_VELOCITY_AT_BOUND + pinch_multiplier_inside(multiplier)
                                      : (int)element->state);
}

void pinch_velocity_states(const pinch_velocity_system *vs, unsigned char *states)
{
    for (int e = 0; e < vs->element_count; e++) states[e] = pinch_velocity_state_of(vs, &vs->elements[e]);
    for (int k = 0; k < vs->rate_count; k++) states[vs->element_count + k] = pinch_rate_row_state(vs, &vs->rates[k]);
}

/* The friction of a slipping contact turns from step to step, so that old factors are no use there. */
bool pinch_velocity_memory_fits(const pinch_velocity_system *vs)
{
    const pinch_step_memory *m = vs->memory;
    int elements = vs->element_count, states = elements + vs->rate_count;
    if (!m || m->tag != vs->tag || m->unknowns != vs->unknowns || m->element_count != states) return false;
    for (int e = 0; e < elements; e++)
        if (m->states[e] != pinch_velocity_state_of(vs, &vs->elements[e]) || m->states[e] == PINCH_CONTACT_SLIP)
            return false;
    for (int k = 0; k < vs->rate_count; k++)
        if (m->states[elements + k] != pinch_rate_row_state(vs, &vs->rates[k])) return false;
    return true;
}

static bool make_room(pinch_step_memory *m, int unknowns, int elements)
{
    if (unknowns > m->unknown_room) {
        size_t n = (size_t)unknowns;
        double *lu = realloc(m->lu, n * n * sizeof *lu);
        if (lu) m->lu = lu;
        int *pivot = realloc(m->pivot, n * sizeof *pivot);
        if (pivot) m->pivot = pivot;
        if (!lu || !pivot) return false;
        m->unknown_room = unknowns;
        m->filled = n * n;
    }
    if (elements > m->element_room) {
        unsigned char *states = realloc(m->states, (size_t)elements);
        if (!states) return false;
        m->states = states;
        m->element_room = elements;
    }
    return true;
}

/* Does a contact slip where the Jacobian was assembled? */
static bool any_slips(const pinch_velocity_system *vs)
{
    bool any = false;
    for (int e = 0; e < vs->element_count; e++) any |= vs->states[e] == PINCH_CONTACT_SLIP;
    return any;
}

void pinch_velocity_remember(pinch_velocity_system *vs, bool good)
{
    pinch_step_memory *m = vs->memory;
    if (!m) return;
    bool fresh = vs->factored && vs->factor_good && !vs->softened && vs->pull == 0;
    if (good && !fresh && pinch_velocity_memory_fits(vs)) return; /* still those of the last time */
    int states = vs->element_count + vs->rate_count;
    m->unknowns = m->element_count = 0;
    m->tag = 0; /* what is saved of a memory without factors is the same, whatever it has held before */
    if (!good || !fresh || any_slips(vs) || !make_room(m, vs->unknowns, states)) return;
    size_t used = vs->factor_size;
    memcpy(m->lu, vs->lu, used * sizeof *m->lu);
    /* it is saved as a whole, by snapshots for one */
    if (m->filled > used) memset(m->lu + used, 0, (m->filled - used) * sizeof *m->lu);
    m->filled = used;
    memcpy(m->pivot, vs->pivot, sizeof *m->pivot * (size_t)vs->unknowns);
    memcpy(m->states, vs->states, (size_t)states);
    m->tag = vs->tag;
    m->unknowns = vs->unknowns;
    m->element_count = states;
}

pinch_status pinch_step_memory_create(pinch_step_memory **memory)
{
    if (!memory) return PINCH_INVALID_ARGUMENT;
    *memory = calloc(1, sizeof **memory);
    return *memory ? PINCH_OK : PINCH_OUT_OF_MEMORY;
}

size_t pinch_step_memory_size(const pinch_step_memory *memory)
{
    size_t n = (size_t)memory->unknown_room, row = n * sizeof *memory->lu + sizeof *memory->pivot;
    return sizeof *memory + n * row + (size_t)memory->element_room * sizeof *memory->states;
}

pinch_step_factors pinch_step_memory_read(const pinch_step_memory *m)
{
    return (pinch_step_factors){m->tag, m->unknowns, m->element_count, m->lu, m->pivot, m->states};
}

static bool legal(const pinch_step_factors *f)
{
    if (f->unknowns < 0 || f->element_count < 0 || (f->unknowns > 0 && (!f->lu || !f->pivot))) return false;
    for (int i = 0; i < f->unknowns; i++)
        if (f->pivot[i] < 0 || f->pivot[i] >= f->unknowns) return false;
    return f->element_count == 0 || f->states;
}

pinch_status pinch_step_memory_write(pinch_step_memory *m, const pinch_step_factors *f)
{
    if (!m || !f || !legal(f)) return PINCH_INVALID_ARGUMENT;
    m->unknowns = m->element_count = 0;
    m->tag = 0;
    if (f->unknowns == 0) return PINCH_OK;
    if (!make_room(m, f->unknowns, f->element_count)) return PINCH_OUT_OF_MEMORY;
    size_t all = (size_t)f->unknowns * (size_t)f->unknowns;
    memcpy(m->lu, f->lu, sizeof *m->lu * all);
    if (m->filled < all) m->filled = all;
    memcpy(m->pivot, f->pivot, sizeof *m->pivot * (size_t)f->unknowns);
    if (f->element_count > 0) memcpy(m->states, f->states, (size_t)f->element_count);
    m->tag = f->tag;
    m->unknowns = f->unknowns;
    m->element_count = f->element_count;
    return PINCH_OK;
}

void pinch_step_memory_destroy(pinch_step_memory *memory)
{
    if (!memory) return;
    free(memory->lu);
    free(memory->pivot);
    free(memory->states);
    free(memory);
}
