#include "support/scene_run.h"

#include "support/arithmetic.h"
#include "support/cmocka_all.h"
#include "support/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

scene *scene_shipped(const char *name)
{
    char path[512];
    scene *s;
    scene_error error;
    snprintf(path, sizeof path, "%s/assets/scenes/%s", PINCH_SOURCE_DIR, name);
    if (scene_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    return s;
}

scene *scene_from_text(const char *text)
{
    scene *s;
    scene_error error;
    char *folder = program_make_folder(), *path = program_write_file(folder, "scene.json", text);
    scene_status status = scene_load(path, &s, &error);
    program_remove_folder(folder);
    free(path);
    if (status != SCENE_OK) fail_msg("%s\n%s", error.text, text);
    return s;
}

world *world_of(const scene *s)
{
    char error[256];
    world *w;
    world_settings settings = world_default_settings(s);
    if (world_create(s, &settings, &w, error) != WORLD_OK) fail_msg("%s", error);
    return w;
}

void world_run_until(world *w, double time)
{
    long steps = lround(time / w->scene->step);
    while (w->steps < steps) assert_int_equal(world_advance(w), WORLD_OK);
}

balance_at_rest world_balance(const world *w)
{
    double force[3], moment[3], cone = 0;
    const pinch_ode_contact *list;
    int count;
    const double *centre = dBodyGetPosition(w->object);
    for (int i = 0; i < 3; i++) { /* the loads, as the scene file says them */
        const double *gravity = w->loads.v[SCENE_GRAVITY], *base = w->loads.v[SCENE_BASE_ACCELERATION];
        force[i] = w->loads.v[SCENE_FORCE][i] + w->scene->objects[0].mass * (gravity[i] - base[i]);
        moment[i] = w->loads.v[SCENE_TORQUE][i];
    }
    assert_int_equal(pinch_ode_contacts(w->plugin, &list, &count), PINCH_OK);
    for (int k = 0; k < count; k++) {
        const pinch_ode_contact *c = &list[k];
        if (c->body1 != w->object && c->body2 != w->object) continue;
        double sign = c->body1 == w->object ? 1 : -1, normal = 0, tangential[3], arm[3];
        for (int i = 0; i < 3; i++) {
            arm[i] = c->position[i] - centre[i];
            normal += c->force[i] * c->normal[i];
        }
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, l = (i + 2) % 3;
            force[i] += sign * c->force[i];
            moment[i] += sign * (arm[j] * c->force[l] - arm[l] * c->force[j] + c->torsion * c->normal[i]);
            tangential[i] = c->force[i] - normal * c->normal[i];
        }
        dGeomID tip = c->geom1 == w->object_geom ? c->geom2 : c->geom1;
        for (int g = 0; g < w->geom_count; g++) {
            if (w->geoms[g] != tip || w->materials[g].model == PINCH_CONTACT_FRICTIONLESS) continue;
            double mu = w->materials[g].friction, reach = length(tangential) / mu;
            if (w->materials[g].model == PINCH_CONTACT_SOFT)
                reach = hypot(reach, c->torsion / w->materials[g].torsional_friction);
            cone = fmax(cone, mu * (reach - normal));
        }
    }
    balance_at_rest left = {length(force), length(moment), cone};
    return left;
}
