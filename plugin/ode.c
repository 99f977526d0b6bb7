/* The plugin's public functions but for the step: life, settings, what is handed over and what is read back. */
#include "ode_state.h"

#include "contacts/contact_buffer.h"
#include "contacts/detection.h"
#include "contacts/materials.h"
#include "contacts/pairs.h"
#include "islands/island_life.h"
#include "joints/joint_rows.h"
#include "ode_internal.h"

#include <math.h>
#include <stdlib.h>

pinch_ode_settings pinch_ode_default_settings(void)
{
    pinch_ode_settings settings = {
        .solver = pinch_default_solver_settings(),
        .stepper = PINCH_ODE_WORLDSTEP,
        .scope = PINCH_ODE_ALL_CONTACTS,
        .tangential_ratio = 2.0 / 3,
        .merge_distance = 0.05,
        .stale_tilt = 0.05,
        .threads = 1,
        .manifold_points = PINCH_SHARED_POINTS,
        .move_bodies = true,
    };
    return settings;
}

static bool is_stepper(pinch_ode_stepper stepper)
{
    return stepper == PINCH_ODE_WORLDSTEP || stepper == PINCH_ODE_QUICKSTEP;
}

pinch_status pinch_check_settings(const pinch_ode_settings *settings)
{
    if (!settings) return PINCH_INVALID_ARGUMENT;
    const pinch_solver_settings *s = &settings->solver;
    if (!(s->tolerance > 0) || !isfinite(s->tolerance) || !(s->goal >= 0) || s->goal > s->tolerance ||
        s->max_iterations < 1)
        return PINCH_INVALID_ARGUMENT;
    if (!(s->budget >= 0) || s->sweeps < 0 || !is_stepper(settings->stepper)) return PINCH_INVALID_ARGUMENT;
    if (!(settings->merge_distance > 0 && settings->merge_distance <= 0.5) ||
        !(settings->stale_tilt >= 0 && settings->stale_tilt <= 0.5))
        return PINCH_INVALID_ARGUMENT;
    if (settings->manifold_points < 1 || settings->manifold_points > PINCH_SHARED_POINTS) return PINCH_INVALID_ARGUMENT;
    if (settings->scope < PINCH_ODE_ALL_CONTACTS || settings->scope > PINCH_ODE_MATERIAL_CONTACTS ||
        !(settings->tangential_ratio > 0 && settings->tangential_ratio <= 10))
        return PINCH_INVALID_ARGUMENT;
    if (settings->threads < 1 || settings->threads > PINCH_ODE_MOST_THREADS) return PINCH_INVALID_ARGUMENT;
    if (settings->faces != 0 && (settings->faces < 2 || settings->faces > 4096)) return PINCH_INVALID_ARGUMENT;
    bool iterative = s->solver >= PINCH_SOLVER_NSNMGK && s->solver < PINCH_SOLVER_LEMKE;
    if (!iterative && (s->solver < PINCH_SOLVER_NSNMGK || s->solver >= PINCH_SOLVER_COUNT))
        return PINCH_INVALID_ARGUMENT;
    return iterative || settings->faces > 0 ? PINCH_OK : PINCH_UNSUPPORTED;
}

pinch_status pinch_ode_create(dWorldID world, const pinch_ode_settings *settings, pinch_ode **plugin)
{
    if (!world || !plugin) return PINCH_INVALID_ARGUMENT;
    pinch_status legal = pinch_check_settings(settings);
    if (legal != PINCH_OK) return legal;

    pinch_ode *p = calloc(1, sizeof *p);
    if (!p) return PINCH_OUT_OF_MEMORY;
    if (!pinch_solver_pool_create(&p->pool, settings->threads)) {
        pinch_solver_pool_destroy(&p->pool);
        free(p);
        return PINCH_OUT_OF_MEMORY;
    }
    p->body_count = -1;
    p->context.world = world;
    p->context.joint_group = dJointGroupCreate(0);
    p->context.settings = *settings;
    pinch_contact_store_init(&p->contacts);
    p->contacts.laws_follow_poses = settings->faces > 0; /* facets turn with their geom */
    p->joints.poses = &p->joints.own_poses;
    *plugin = p;
    return PINCH_OK;
}

void pinch_ode_destroy(pinch_ode *p)
{
    if (!p) return;
    dJointGroupDestroy(p->context.joint_group);
    pinch_solver_pool_destroy(&p->pool);
    pinch_contact_store_free(&p->contacts);
    pinch_detection_free(&p->detection);
    pinch_joint_store_free(&p->joints);
    pinch_island_graph_free(&p->graph);
    free(p);
}

pinch_status pinch_ode_set_stepper(pinch_ode *p, pinch_ode_stepper stepper)
{
    if (!p || !is_stepper(stepper)) return PINCH_INVALID_ARGUMENT;
    p->context.settings.stepper = stepper;
    return PINCH_OK;
}

pinch_status pinch_ode_set_body_count(pinch_ode *p, int count)
{
    if (!p || count < -1) return PINCH_INVALID_ARGUMENT;
    p->body_count = count;
    return PINCH_OK;
}

/* ---- what is handed over ---- */

/* Where contacts go, in which no pair of a geom or body is left that is forgotten. */
static pinch_contact_sink sink_of(pinch_ode *p)
{
    if (p->contacts.forgot_pairs) pinch_drop_forgotten(p);
    return (pinch_contact_sink){&p->contacts, &p->context, &p->graph.bodies.drives, &p->stats};
}

pinch_status pinch_ode_add_contact(pinch_ode *p, const dContact *contact, dBodyID body1, dBodyID body2)
{
    if (!p || !contact || p->solved) return PINCH_INVALID_ARGUMENT;
    const pinch_contact_sink sink = sink_of(p);
    if (p->pool.workers) pinch_expect_step(p);
    return pinch_buffer_contact(&sink, contact, body1, body2);
}

pinch_status pinch_ode_each_pair(pinch_ode *p, dSpaceID space, void *context, dNearCallback *near)
{
    if (!p || !space || !near || p->solved || p->detecting) return PINCH_INVALID_ARGUMENT;
    p->detecting = true;
    pinch_status status = pinch_each_pair(&p->detection, space, context, near);
    p->detecting = false;
    return status;
}

pinch_status pinch_ode_collide(pinch_ode *p, dSpaceID space, int most, pinch_ode_near near, void *context)
{
    const pinch_detection_request request = {space, most, near, context};
    if (!p || !space || most < 1 || !near || p->solved || p->detecting) return PINCH_INVALID_ARGUMENT;
    const pinch_contact_sink sink = sink_of(p);
    p->detecting = true;
    pinch_status status = pinch_detect(&p->detection, p->pool.workers, &request, &sink);
    p->detecting = false;
    return status;
}

pinch_status pinch_ode_add_joint(pinch_ode *p, dJointID joint, const dContact *contact)
{
    if (!p || !joint || !contact || p->solved) return PINCH_INVALID_ARGUMENT;
    if (!dJointIsEnabled(joint)) return PINCH_OK; /* the program has switched it off */
    const dBodyID body[2] = {dJointGetBody(joint, 0), dJointGetBody(joint, 1)};
    return pinch_add_joint_between(p, joint, body, contact);
}

pinch_status pinch_add_joint_between(pinch_ode *p, dJointID joint, const dBodyID body[2], const dContact *contact)
{
    if (p->solved) return PINCH_INVALID_ARGUMENT;
    pinch_contact_joint own = {joint, {body[0], body[1]}, false};
    const pinch_contact_sink sink = sink_of(p);
    if (p->pool.workers) pinch_expect_step(p);
    return pinch_buffer_contact_joint(&sink, &own, contact);
}

pinch_status pinch_ode_add_body(pinch_ode *p, dBodyID body)
{
    if (!p || !body || p->solved) return PINCH_INVALID_ARGUMENT;
    if (!PINCH_RESERVE(p->graph.handed, p->graph.handed.count + 1)) return PINCH_OUT_OF_MEMORY;
    p->graph.handed.items[p->graph.handed.count++] = body;
    return PINCH_OK;
}

pinch_status pinch_ode_set_material(pinch_ode *p, dGeomID geom, const pinch_material *material)
{
    if (!p || !geom) return PINCH_INVALID_ARGUMENT;
    return pinch_set_material(&p->contacts, geom, material);
}

pinch_status pinch_ode_forget_geom(pinch_ode *p, dGeomID geom)
{
    if (!p || !geom) return PINCH_INVALID_ARGUMENT;
    pinch_near_forget(&p->detection.near, geom);
    int index = pinch_find_geom(&p->contacts, geom);
    if (index < 0) return PINCH_OK;
    pinch_forget_pairs_of(&p->contacts, index);
    pinch_forget_side(&p->contacts, geom, NULL);
    return PINCH_OK;
}

/* Returns false when memory runs out. */
static bool note_forgotten(pinch_ode *p, dBodyID body)
{
    if (pinch_forget_pairs_of_body(&p->contacts, body)) return true;
    pinch_drop_forgotten(p); /* makes room */
    return pinch_forget_pairs_of_body(&p->contacts, body);
}

pinch_status pinch_ode_forget_body(pinch_ode *p, dBodyID body)
{
    if (!p || !body || p->solved) return PINCH_INVALID_ARGUMENT;
    if (!note_forgotten(p, body)) return PINCH_OUT_OF_MEMORY;
    pinch_forget_side(&p->contacts, NULL, body);
    pinch_island_graph_forget(&p->graph, body);
    pinch_joint_poses_forget_body(p->joints.poses, body);
    p->contacts.same_bodies =
        false; /* islands are built anew: they are compared by the addresses of bodies and joints */
    return PINCH_OK;
}

pinch_status pinch_ode_forget_joint(pinch_ode *p, dJointID joint)
{
    if (!p || !joint || p->solved) return PINCH_INVALID_ARGUMENT;
    pinch_joint_store_forget_joint(&p->joints, joint);
    p->contacts.same_bodies = false;
    return PINCH_OK;
}

pinch_status pinch_ode_set_drive(pinch_ode *p, dBodyID body, const double axis[3], double force)
{
    bool changed;
    if (!p || !body || !isfinite(force) || force < 0 || p->solved) return PINCH_INVALID_ARGUMENT;
    pinch_status status = pinch_drives_set(&p->graph.bodies.drives, body, axis, force, &changed);
    if (changed) pinch_invalidate_step_cache(&p->contacts);
    return status;
}

pinch_status pinch_ode_note_joint(pinch_ode *p, dJointID joint)
{
    pinch_joint_pose pose;
    if (!p || !joint) return PINCH_INVALID_ARGUMENT;
    if (dJointGetType(joint) == dJointTypePlane2D)
        return pinch_joint_is_new(p->joints.poses, joint, dJointTypePlane2D, dWorldGetCFM(p->context.world))
                   ? PINCH_OK
                   : PINCH_OUT_OF_MEMORY;
    if (!pinch_joint_pose_now(joint, &pose)) return PINCH_INVALID_ARGUMENT;
    return pinch_joint_pose_keep(p->joints.poses, &pose) ? PINCH_OK : PINCH_OUT_OF_MEMORY;
}

pinch_status pinch_ode_note_linear_motor(pinch_ode *p, dJointID joint, int axis, int frame)
{
    if (!p || !joint || dJointGetType(joint) != dJointTypeLMotor) return PINCH_INVALID_ARGUMENT;
    return pinch_note_motor_frame(p->joints.poses, joint, axis, frame) ? PINCH_OK : PINCH_INVALID_ARGUMENT;
}

pinch_status pinch_ode_note_plane_motor(pinch_ode *p, dJointID joint, int motor, int parameter, double value)
{
    if (!p || !joint || dJointGetType(joint) != dJointTypePlane2D) return PINCH_INVALID_ARGUMENT;
    return pinch_note_plane_motor(p->joints.poses, joint, motor, parameter, value) ? PINCH_OK : PINCH_INVALID_ARGUMENT;
}

pinch_servo pinch_default_servo(void)
{
    return (pinch_servo){.max_force = INFINITY};
}

pinch_status pinch_ode_set_servo(pinch_ode *p, dJointID joint, int axis, const pinch_servo *servo)
{
    if (!p || !joint || p->solved) return PINCH_INVALID_ARGUMENT;
    return pinch_servo_set(&p->joints.servos, joint, axis, servo);
}

pinch_status pinch_ode_servo_state(const pinch_ode *p, dJointID joint, int axis, double *position, double *force)
{
    if (!p || !joint || !position || !force || axis < 0 || axis >= PINCH_JOINT_AXES) return PINCH_INVALID_ARGUMENT;
    int hint = 0;
    const pinch_joint_servos *servos = pinch_servos_of(&p->joints.servos, joint, &hint);
    if (!servos || !servos->axis[axis].used || !servos->axis[axis].coordinate.placed) return PINCH_INVALID_ARGUMENT;
    *position = servos->axis[axis].coordinate.position;
    *force = servos->axis[axis].force;
    return PINCH_OK;
}

pinch_status pinch_ode_couple(pinch_ode *p, const pinch_coupling_term *terms, int count, const pinch_servo *law,
                              int *coupling)
{
    if (!p || !terms || !law || !coupling || p->solved) return PINCH_INVALID_ARGUMENT;
    return pinch_coupling_make(&p->joints.couplings, terms, count, law, coupling);
}

pinch_status pinch_ode_set_coupling(pinch_ode *p, int coupling, const pinch_servo *law)
{
    if (!p || p->solved) return PINCH_INVALID_ARGUMENT;
    return pinch_coupling_set(&p->joints.couplings, coupling, law);
}

pinch_status pinch_ode_coupling_state(const pinch_ode *p, int coupling, double *position, double *force)
{
    if (!p || !position || !force) return PINCH_INVALID_ARGUMENT;
    const pinch_coupling *c = pinch_coupling_of(&p->joints.couplings, coupling);
    if (!c || !c->placed) return PINCH_INVALID_ARGUMENT;
    *position = c->position;
    *force = c->force;
    return PINCH_OK;
}

void pinch_use_joint_poses(pinch_ode *p, pinch_joint_poses *poses)
{
    p->joints.poses = poses;
}

void pinch_leave_motion_to_ode(pinch_ode *p)
{
    p->context.settings.move_bodies = false;
}

/* ---- what is read back ---- */

pinch_status pinch_ode_contacts(const pinch_ode *p, const pinch_ode_contact **list, int *count)
{
    if (!p || !list || !count) return PINCH_INVALID_ARGUMENT;
    *list = p->contacts.results.items;
    *count = p->contacts.results.count;
    return PINCH_OK;
}

pinch_status pinch_ode_geom_load(const pinch_ode *p, dGeomID geom, const double about[3], pinch_ode_load *load)
{
    if (!p || !geom || !load) return PINCH_INVALID_ARGUMENT;
    return pinch_sum_load(&p->contacts, geom, NULL, about, load);
}

pinch_status pinch_ode_pair_load(const pinch_ode *p, dGeomID geom, dGeomID partner, const double about[3],
                                 pinch_ode_load *load)
{
    if (!p || !geom || !partner || !load) return PINCH_INVALID_ARGUMENT;
    return pinch_sum_load(&p->contacts, geom, partner, about, load);
}

int pinch_ode_island_count(const pinch_ode *p)
{
    return p && p->solved ? p->graph.count : 0;
}

pinch_status pinch_ode_read_island(const pinch_ode *p, int index, pinch_problem *problem, int *places)
{
    if (!problem || !places || index < 0 || index >= pinch_ode_island_count(p) || !p->context.settings.keep_islands)
        return PINCH_INVALID_ARGUMENT;
    const pinch_island *island = &p->graph.items[index];
    const pinch_problem_buffers *kept = &p->pool.kept;
    *problem = (pinch_problem){
        .step = p->context.h,
        .faces = p->context.settings.faces,
        .body_count = island->bodies.count,
        .contact_count = island->contacts.count,
        .row_count = island->joints.row_count + island->drive_rows,
        .bodies = kept->bodies.items + island->bodies.first,
        .contacts = kept->contacts.items + island->contacts.first,
        .rows = kept->rows.items + island->joints.room.first,
    };
    for (int i = 0; i < island->pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(&p->contacts, island->pairs, i);
        for (int k = 0; k < pair->manifold.count; k++) places[pair->first_in_island + k] = pair->first_result + k;
    }
    return PINCH_OK;
}

pinch_status pinch_ode_read_outcome(const pinch_ode *p, int index, pinch_ode_outcome *outcome)
{
    if (!outcome || index < 0 || index >= pinch_ode_island_count(p)) return PINCH_INVALID_ARGUMENT;
    const pinch_island *island = &p->graph.items[index];
    memset(outcome, 0, sizeof *outcome);
    outcome->solved = pinch_island_is_solved(island);
    outcome->asleep = island->phase == PINCH_ISLAND_ASLEEP;
    outcome->reused = island->phase == PINCH_ISLAND_REUSED;
    outcome->tried = island->tried && !outcome->reused;
    outcome->first_solve_failed = outcome->tried && island->first_solve_failed;
    if (outcome->tried) outcome->result = island->result;
    return PINCH_OK;
}

pinch_status pinch_ode_contact_energy(const pinch_ode *p, pinch_ode_energy *energy)
{
    if (!p || !energy || p->solved || !p->context.settings.keep_islands) return PINCH_INVALID_ARGUMENT;
    pinch_contact_energy(&p->graph, &p->contacts, &p->pool.kept, p->last_h, energy);
    return PINCH_OK;
}

void pinch_count(const pinch_ode *p, pinch_ode_stats *stats)
{
    size_t memory = stats->memory;
    *stats = p->stats;
    stats->memory = memory;
}

pinch_ode_stats pinch_ode_statistics(const pinch_ode *p)
{
    pinch_ode_stats stats = p->stats;
    stats.memory = sizeof *p + pinch_contact_store_bytes(&p->contacts) + pinch_joint_store_bytes(&p->joints) +
                   pinch_island_graph_bytes(&p->graph) + pinch_solver_pool_bytes(&p->pool) +
                   pinch_detection_bytes(&p->detection);
    return stats;
}

void pinch_ode_reset_statistics(pinch_ode *p)
{
    memset(&p->stats, 0, sizeof p->stats);
    p->recount_at_rest = true;
}
