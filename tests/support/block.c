#include "support/block.h"

#include "support/cmocka_all.h"

#include <string.h>

pinch_material block_material(void)
{
    pinch_material m = pinch_default_material();
    m.damping[0] = 60;
    m.damping[1] = 40;
    return m;
}

void block_make(block *b, const pinch_material *material, double depth)
{
    memset(b, 0, sizeof *b);
    b->world = dWorldCreate();
    dWorldSetGravity(b->world, 0, 0, -10);
    b->body = dBodyCreate(b->world);
    dMass mass;
    dMassSetBoxTotal(&mass, 0.1, 0.04, 0.04, 0.04);
    dBodySetMass(b->body, &mass);
    dBodySetPosition(b->body, 0, 0, 0.02 - depth);
    b->cube = dCreateBox(NULL, 0.04, 0.04, 0.04);
    dGeomSetBody(b->cube, b->body);
    b->table = dCreateBox(NULL, 20, 20, 1);
    dGeomSetPosition(b->table, 0, 0, -0.5);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.scope = PINCH_ODE_MATERIAL_CONTACTS;
    assert_int_equal(pinch_ode_create(b->world, &settings, &b->plugin), PINCH_OK);
    if (material) assert_int_equal(pinch_ode_set_material(b->plugin, b->table, material), PINCH_OK);
}

void block_free(block *b)
{
    pinch_ode_destroy(b->plugin);
    if (b->cube) dGeomDestroy(b->cube);
    if (b->table) dGeomDestroy(b->table);
    dWorldDestroy(b->world);
}

int block_hand_over(block *b, bool swapped)
{
    dContactGeom found[BLOCK_POINTS];
    int count = dCollide(b->cube, b->table, BLOCK_POINTS, found, sizeof found[0]);
    for (int i = 0; i < count; i++) {
        dContact contact;
        memset(&contact, 0, sizeof contact);
        contact.geom = found[i];
        contact.surface.mode = dContactApprox1;
        contact.surface.mu = 0.5;
        if (swapped) {
            contact.geom.g1 = found[i].g2;
            contact.geom.g2 = found[i].g1;
            for (int k = 0; k < 3; k++) contact.geom.normal[k] = -found[i].normal[k];
        }
        assert_int_equal(
            pinch_ode_add_contact(b->plugin, &contact, dGeomGetBody(contact.geom.g1), dGeomGetBody(contact.geom.g2)),
            PINCH_OK);
    }
    return count;
}

void block_step(block *b, double h)
{
    block_hand_over(b, false);
    assert_int_equal(pinch_ode_step(b->plugin, h), PINCH_OK);
}

void block_steps(block *b, int count)
{
    for (int i = 0; i < count; i++) block_step(b, 1e-3);
}

double block_normal_force(const block *b)
{
    const pinch_ode_contact *list;
    int count;
    double sum = 0;
    assert_int_equal(pinch_ode_contacts(b->plugin, &list, &count), PINCH_OK);
    for (int i = 0; i < count; i++) sum += list[i].normal_force;
    return sum;
}

void block_force(const block *b, double force[3])
{
    const pinch_ode_contact *list;
    int count;
    memset(force, 0, 3 * sizeof *force);
    assert_int_equal(pinch_ode_contacts(b->plugin, &list, &count), PINCH_OK);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) force[k] += (list[i].body1 == b->body ? 1 : -1) * list[i].force[k];
}
