/*
 * A parallel gripper lifts a box. Each jaw slides on the palm and is closed by a servo that is held to 25 N; the palm
 * is moved by the program. At the end every jaw's load on the box is read out: forces, torsion, slip and what is left
 * of the friction limit.
 */
#include <pinch/ode.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { JAWS = 2, MOST_POINTS = 8 };

static const double STEP = 0.001, GRIP = 25, BOX_MASS = 0.8, BOX = 0.06, PAD = 0.01;

typedef struct gripper {
    dWorldID world;
    dSpaceID space;
    pinch_ode *pinch;
    dBodyID palm, jaw[JAWS], box;
    dGeomID pad[JAWS], box_geom, floor;
    dJointID slider[JAWS];
} gripper;

/* Every call of Pinch's says whether it was legal. */
static void check(pinch_status status)
{
    if (status == PINCH_OK) return;
    fprintf(stderr, "gripper: %s\n", pinch_status_text(status));
    exit(1);
}

static dBodyID add_body(gripper *g, double mass, double x, double z)
{
    dMass m;
    dBodyID body = dBodyCreate(g->world);
    dMassSetBoxTotal(&m, mass, BOX, BOX, BOX);
    dBodySetMass(body, &m);
    dBodySetPosition(body, x, 0, z);
    return body;
}

static void add_jaw(gripper *g, int i)
{
    double side = i ? 1 : -1, x = side * (BOX / 2 + PAD + 0.004); /* 4 mm away from the box */
    g->jaw[i] = add_body(g, 0.1, x, BOX / 2);
    g->pad[i] = dCreateBox(g->space, 2 * PAD, 0.02, 0.02);
    dGeomSetBody(g->pad[i], g->jaw[i]);

    pinch_material rubber = pinch_default_material();
    rubber.model = PINCH_CONTACT_SOFT;
    rubber.friction = rubber.friction_kinetic = 0.8;
    rubber.torsional_friction = 0.005;
    check(pinch_ode_set_material(g->pinch, g->pad[i], &rubber));

    g->slider[i] = dJointCreateSlider(g->world, NULL);
    dJointAttach(g->slider[i], g->jaw[i], g->palm);
    dJointSetSliderAxis(g->slider[i], 1, 0, 0);
    check(pinch_ode_note_joint(g->pinch, g->slider[i]));

    /* The target is 2 cm inside the box: the servo pushes with all it has. */
    pinch_servo servo = pinch_default_servo();
    servo.target = -side * 0.02;
    servo.kp = 1e4;
    servo.kd = 100;
    servo.max_force = GRIP;
    check(pinch_ode_set_servo(g->pinch, g->slider[i], 0, &servo));
}

static void build(gripper *g)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    g->world = dWorldCreate();
    g->space = dHashSpaceCreate(NULL);
    dWorldSetGravity(g->world, 0, 0, -9.81);
    check(pinch_ode_create(g->world, &settings, &g->pinch));
    g->floor = dCreatePlane(g->space, 0, 0, 1, 0);
    g->box = add_body(g, BOX_MASS, 0, BOX / 2);
    g->box_geom = dCreateBox(g->space, BOX, BOX, BOX);
    dGeomSetBody(g->box_geom, g->box);
    g->palm = add_body(g, 1, 0, 0.2);
    dBodySetKinematic(g->palm);
    for (int i = 0; i < JAWS; i++) add_jaw(g, i);
}

/* The pads meet the box, and the box meets the floor. */
static void near_callback(void *data, dGeomID a, dGeomID b)
{
    gripper *g = data;
    dContact contact[MOST_POINTS];
    if (a != g->box_geom && b != g->box_geom) return;
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, MOST_POINTS, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mode = dContactApprox1; /* used on the floor, which has no material */
        contact[i].surface.mu = 0.5;
        check(pinch_ode_add_contact(g->pinch, &contact[i], dGeomGetBody(a), dGeomGetBody(b)));
    }
}

static void simulate(gripper *g, double seconds, double palm_speed)
{
    for (int i = 0; i < (int)(seconds / STEP + 0.5); i++) {
        dBodySetLinearVel(g->palm, 0, 0, palm_speed);
        dSpaceCollide(g->space, g, near_callback);
        check(pinch_ode_step(g->pinch, STEP));
    }
}

static void print_loads(gripper *g)
{
    for (int i = 0; i < JAWS; i++) {
        pinch_ode_load load;
        double position, force;
        check(pinch_ode_pair_load(g->pinch, g->box_geom, g->pad[i], NULL, &load));
        check(pinch_ode_servo_state(g->pinch, g->slider[i], 0, &position, &force));
        printf(
            "jaw %d: motor %.6f N, presses %.6f N, lifts %.6f N, torsion %.6f N m, slipped %.3f um, margin %.4f, %s\n",
            i, force, load.normal_force, load.tangential[2], load.torsion, 1e6 * load.slip_total, load.slip_margin,
            pinch_contact_state_text(load.state));
    }
}

int main(void)
{
    gripper g;
    memset(&g, 0, sizeof g);
    dInitODE();
    build(&g);
    simulate(&g, 0.5, 0); /* close */
    simulate(&g, 1, 0.1); /* lift by 10 cm */
    simulate(&g, 0.5, 0); /* hold */
    print_loads(&g);

    const double *p = dBodyGetPosition(g.box);
    pinch_ode_stats stats = pinch_ode_statistics(g.pinch);
    printf("the box is %.6f m up; steps without an answer: %ld\n", p[2] - BOX / 2, stats.fallback_islands);
    int held = p[2] > BOX / 2 + 0.095 && stats.fallback_islands == 0;

    pinch_ode_destroy(g.pinch);
    dSpaceDestroy(g.space);
    dWorldDestroy(g.world);
    dCloseODE();
    return held ? 0 : 1;
}
