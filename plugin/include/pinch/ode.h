#ifndef PINCH_ODE_H
#define PINCH_ODE_H

#include <ode/ode.h>
#include <pinch/problem.h>
#include <pinch/version.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Pinch as the contact solver of an ODE world.
 *
 * Contacts from dCollide are handed over with pinch_ode_add_contact in the near callback, instead of being made contact
 * joints; pinch_ode_step solves their forces, adds them to the bodies and lets ODE's own step treat joints and
 * integrate. Each pair of geoms keeps a persistent manifold: contact points with their elastic tangential state, which
 * is what makes a held object stay. An object all of whose motions are rounding is brought to rest: zero velocities,
 * and a pose that keeps its bits; where nothing has changed since the last step, its verified answer is given again,
 * and ODE's step leaves its bodies out: their moved callbacks are not called, and to others' they are disabled. Nor are
 * moved callbacks called for bodies that Pinch moves by itself (settings.move_bodies, on by default). SI units, world
 * frame.
 */

/* What Pinch keeps of a world. One thread at a time may use it, as it may use the world; what belongs to different
 * worlds may be used by different threads at the same time, as nothing here is shared between worlds. */
typedef struct pinch_ode pinch_ode;

/* One fingertip: stiffness and damping belong to the whole tip, however many contact points it has at the moment. */
typedef struct pinch_material {
    pinch_contact_model model; /* frictionless, hard or soft */
    double stiffness[3];       /* normal, tangential (N/m, > 0), torsional (N m/rad, > 0 when soft) */
    double damping[3];         /* normal, tangential (N s/m, >= 0), torsional (N m s/rad, >= 0) */
    double friction;           /* coefficient at which a sticking point starts to slip, >= 0; infinity allowed */
    double friction_kinetic;   /* coefficient at which a slipping point goes on, 0 <= friction_kinetic <= friction */
    double torsional_friction; /* m, >= 0 when soft */
    double max_force;          /* N, > 0; INFINITY for none */
    double hertz_modulus;      /* Pa, >= 0; 0 (default): the normal stiffness is linear. Else it follows the depth by
                                * Hertz' law: modulus E* = E/(1 - nu^2), F = 4/3 E* sqrt(R) delta^(3/2), R the relative
                                * radius of curvature of the two geoms where they touch (Johnson, Contact Mechanics,
                                * 1985). In each step kn is the secant F/delta at the depth it starts from, so that the
                                * step's law stays linear and rest is exactly Hertz'; the tangential stiffness keeps its
                                * ratio to kn. Of two such tips the compliances add (1/E*). stiffness[0] holds where the
                                * law does not: lines, faces, edges, geoms of unknown curvature. The energy stored along
                                * the normal is Hertz', 2/5 F delta at rest. The tangential stiffness changes with kn
                                * from step to step, and the energy of a shear with it, which no term of
                                * pinch_ode_energy has */
    double facet_axis[3];      /* in the geom's frame: facet 0 of a linearized cone points along its part in the tangent
                                * plane; all zero (default): any direction */
} pinch_material;

/* Returns a hard contact with stiffness 2e4 N/m along the normal and 1.33e4 N/m along tangents, damping 20 and
 * 13.3 N s/m, and friction 0.5 (static and kinetic). Its torsional values, which count when it is made soft, are
 * 1 N m/rad and 1 mm. It has no force limit. */
PINCH_API pinch_material pinch_default_material(void);

typedef enum pinch_ode_stepper {
    PINCH_ODE_WORLDSTEP = 0, /* dWorldStep: joints exactly; its cost grows with the cube of an island's joint rows */
    PINCH_ODE_QUICKSTEP      /* dWorldQuickStep */
} pinch_ode_stepper;

/*
 * Which contacts Pinch solves; the others are left to ODE's own solver. Contacts of geoms with a material always are.
 * Where Pinch and ODE share the contacts of one body, Pinch solves its own as if ODE's were not there, and ODE solves
 * the rest with Pinch's forces given: a soft finger on a box that rests on ODE's ground carries too much of its weight.
 */
typedef enum pinch_ode_scope {
    PINCH_ODE_ALL_CONTACTS = 0, /* those without a material by their ODE surface parameters */
    PINCH_ODE_SOFT_CONTACTS,    /* of those without a material the ones with dContactSoftCFM */
    PINCH_ODE_MATERIAL_CONTACTS /* no others */
} pinch_ode_scope;

enum { PINCH_ODE_MOST_THREADS = 64 };

/* One solve of one island, as a recorder is shown it; good for that call only. */
typedef struct pinch_ode_recording {
    long step;                             /* number of the plugin's step, from 0 */
    int island;                            /* its number in the step */
    const pinch_solver_settings *settings; /* of the solve */
    const pinch_problem *problem;          /* as it was before the solve */
    const pinch_problem *ended;            /* after it: an answer, or what the solver ended with */
    const pinch_step_result *result;       /* how the solve ended */
} pinch_ode_recording;

/* It must not call the plugin. With several threads it is called from all of them. It may be shown an island several
 * times in a step: where joints or contacts put too much energy in, the island is solved again at a slower pace. */
typedef void (*pinch_ode_recorder)(void *context, const pinch_ode_recording *recording);

/* How a world is stepped. Set by pinch_ode_create, and fixed from then on but for the stepper. */
typedef struct pinch_ode_settings {
    pinch_solver_settings solver; /* NSNMGK, NSNGRK or Newton; with faces > 0 also Lemke and PGS */
    int faces; /* 0: the exact friction cone (default); 2 to 4096: the linearized one, see pinch_problem */
    pinch_ode_stepper stepper; /* what ODE runs for joints and integration; default PINCH_ODE_WORLDSTEP */
    pinch_ode_scope scope;     /* default PINCH_ODE_ALL_CONTACTS */
    double tangential_ratio;   /* kt/kn and ct/cn of contacts that have ODE surface parameters and no material; in
                                * (0, 10], default 2/3: Mindlin's ratio 2 (1 - nu)/(2 - nu) for rubber, nu = 0.5 */
    double merge_distance;     /* a detected contact point this near (times the smaller geom's size) to a known one
                                * continues it; in (0, 0.5], default 0.05 */
    double stale_tilt; /* rad: a point that the collider did not return stays while the two bodies have not tilted
                        * more than this against each other since it was last seen; in [0, 0.5], default 0.05 */
    int threads; /* that share the work of a step, the caller's own counted; in [1, PINCH_ODE_MOST_THREADS], default
                  * 1. Results are the same to the bit for any number. Colliders that a program has set by
                  * dSetColliderOverride are called by any of them. ODE's own step has threads of its own
                  * (dWorldSetStepThreadingImplementation). */
    bool joints_by_ode;  /* false (default): where Pinch knows all that acts on the bodies of a contact in full, the
                          * joints included, it gives the joints' forces from its own solve. They are exact under either
                          * stepper. ODE integrates; the joints are disabled while it steps, and their feedback is
                          * filled. True: ODE solves all joints once more, to compare the two. ODE always solves the
                          * joints of islands with a joint whose state it does not show and nobody has told (see
                          * pinch_ode_note_joint), and with contact joints of others. Where quickstep's sweeps leave such
                          * joints so far from holding that contact forces found for them do harm, ODE gets the island's
                          * contacts as well, for a while. It gets both at once where joints that it solves have rows
                          * that depend on each other (loops, doubled joints), and where joints have been torn so far
                          * apart that holding them at once would put in much energy */
    bool cold_start;     /* true: a solve knows nothing of the last step's forces and factorizations, for measuring what
                          * these are worth; contact histories go on. Default false */
    bool solve_at_rest;  /* true: an island at rest is solved anew in every step, though nothing has changed; for
                          * measuring what a solve costs. Default false */
    bool move_bodies;    /* true (default): bodies that ODE would only integrate are moved by Pinch, as under ODE, to
                          * the bit, and the threads share the work. Pinch has found all forces on them, or they are
                          * kinematic and touch something, or joints tie them to what does. ODE does not see them in
                          * its step: their moved callbacks (dBodySetMovedCallback) are not called, and to those of
                          * others they are disabled. Bodies that may go to sleep or have an enabled joint that Pinch
                          * has not solved are ODE's in any case. False: ODE moves all bodies but those of islands at
                          * rest */
    int manifold_points; /* of one pair of geoms with a material, at most; 1 to 8, default 8. Contacts with surface
                          * parameters of their own keep up to 64 of a pair, or this many where it is less than 8 */
    bool keep_islands;   /* true: what was solved stays until the next step, for pinch_ode_read_island and
                          * pinch_ode_contact_energy; some 700 bytes a contact. Default false */
    bool ode_solves; /* true: the contacts keep their persistent manifolds, and ODE's own stepper solves the points, for
                      * comparisons: fingertips as far as its contacts can say them (normal stiffness and damping,
                      * friction). Default false */
    pinch_ode_recorder recorder; /* is shown islands whose first solve failed or gave an answer that is too soft; NULL
                                  * (default): none */
    void *recorder_context;      /* is handed to it */
    bool record_all; /* true: the recorder is shown each first attempt, also where it converged. Later attempts by
                      * other solvers are never shown. Default false */
} pinch_ode_settings;

PINCH_API pinch_ode_settings pinch_ode_default_settings(void);

/* PINCH_INVALID_ARGUMENT for a NULL pointer or settings out of range, PINCH_UNSUPPORTED for a solver that cannot step,
 * PINCH_OUT_OF_MEMORY also where the system gives no threads. */
PINCH_API pinch_status pinch_ode_create(dWorldID world, const pinch_ode_settings *settings, pinch_ode **plugin);
/* To be called before the world is destroyed. NULL is allowed. */
PINCH_API void pinch_ode_destroy(pinch_ode *plugin);

/*
 * Gives `geom` the material of a fingertip; NULL takes it away. Where two geoms with materials touch, their compliances
 * act in series and the smaller friction counts. The pair is soft where one of them is, and has the torsional values of
 * that one; it is frictionless where one of them is. May change from step to step; contact histories go on.
 */
PINCH_API pinch_status pinch_ode_set_material(pinch_ode *plugin, dGeomID geom, const pinch_material *material);

/*
 * Puts the kinematic `body` under force control: it is driven along the unit vector `axis` (world) without inertia, so
 * that its contacts push back with exactly `force` (N, > 0) along it. Its own linear velocity comes on top. A body that
 * touches nothing stays where it is. Contacts whose normals have turned away from the axis cannot push back: the body
 * then goes on, in a step at most by a quarter of the size of the smaller geom that touches, until a contact bears the
 * force or none is left; drives_at_limit of the statistics counts that. force = 0 ends it. Not to be called between
 * pinch_ode_solve and pinch_ode_advance.
 */
PINCH_API pinch_status pinch_ode_set_drive(pinch_ode *plugin, dBodyID body, const double axis[3], double force);

/*
 * Hands over one contact for the next step. Every contact with a depth counts, however many a pair has. Those of a
 * fingertip are shares of its stiffness: of more than the manifold holds, those that span the others stand for all. Of
 * those with surface parameters of their own up to 64 of a pair are solved one by one, and of more some stand for those
 * around them, with the same parameters where there are no more than 16 kinds: they bear, tilt and slip as all do. g1
 * and g2 are geoms or NULL; where one is NULL, its body takes its place in the pair, or the world. The contact's
 * geometry is used, and where neither geom has a material its surface parameters, which keep their meaning in ODE: soft
 * ERP and CFM or the world's, mu as coefficient (dContactApprox1: an ellipse where mu2 differs) or as a force, bounce
 * (1 at most), motion1/2/N, slip1/2 (those give way without a spring), rho, rho2 and rhoN. A negative depth counts as 0
 * then; where a geom has a material, it is a gap that may close. Other tangents get a spring in proportion to the
 * normal one (settings.tangential_ratio), so that what sticks does not creep. Infinite mu holds without a limit what
 * pressed in the last step; a contact that begins to press has 10 as its coefficient until then. As in ODE this is a
 * row without a limit, and mu as a force does not ask for a normal force either: the step in which a contact lifts off
 * still drags.
 * (A material of infinite friction does not.)
 *
 * Stiff contacts are solved with a floor under their compliance, a small part (1e-4 at first) of what the bodies'
 * inertia gives them in a step. The floor is raised where a step is too hard, and lowered again where it lets something
 * sink; floor_level_max, softened_islands and floor_depth_max of the statistics tell. A step whose floor gives way by
 * more than a hundredth (too_soft_islands) counts as unconverged.
 *
 * Some contacts are left to ODE's own solver as contact joints: those outside settings.scope; those with parameters
 * that are no numbers or an ERP outside [0, 1]; and all those by surface parameters where the solver
 * takes no Newton steps, settings.faces is not 0 or a body is under force control. A malformed contact (not finite, a
 * normal whose length is not 1 to about 5e-4, twice the same body, no body that can move) is skipped and counted.
 * Contacts wait where all their bodies are disabled; bodies wake as in ODE. Those that are to be disabled by themselves
 * (dBodySetAutoDisableFlag) are so by ODE's thresholds, but all bodies that contacts and joints tie to each other in
 * the same step, by pinch_ode_solve; until then none of them is stopped. PINCH_INVALID_ARGUMENT: a NULL plugin or
 * contact, or a call between pinch_ode_solve and pinch_ode_advance.
 */
PINCH_API pinch_status pinch_ode_add_contact(pinch_ode *plugin, const dContact *contact, dBodyID body1, dBodyID body2);

/*
 * Does what dSpaceCollide does, for less: calls `near` once for each pair of geoms in the space whose boxes overlap.
 * The pairs are those of dSpaceCollide, but that hash spaces lose some, geoms with a size of 0 meet others here, and
 * pairs with an inner space are given without the test of a geom's class (dGeomClass.aabb_test). They come in another
 * order: ODE's changes with each geom that moves; here the geom that was seen first comes first, and of those that are
 * new, in simple and hash spaces, the one that came into the space first, if none of them has moved since. So what is
 * handed over keeps its order from step to step. A geom is known by its address, also where that was another one's
 * before.
 *
 * Which geoms are close to each other is kept as well, and found out anew only for those that have left the place where
 * they were looked for. `near` may hand over contacts and disable geoms; it must not move or destroy them, nor change
 * the space.
 */
PINCH_API pinch_status pinch_ode_each_pair(pinch_ode *plugin, dSpaceID space, void *context, dNearCallback *near);

/*
 * Finds the contacts of two geoms whose boxes overlap, as a near callback does: writes at most `room` of them, with
 * their surface parameters, and returns how many. Neither geom is a space, and *contacts is not cleared. With several
 * threads it is called from all of them, for different pairs, and so are the functions of a program's own geom classes;
 * it must not call the plugin, and of ODE only what reads, as dCollide does. Contacts name the two geoms in either
 * order, other geoms of the same bodies, or none.
 */
typedef int (*pinch_ode_near)(void *context, dGeomID geom1, dGeomID geom2, int room, dContact *contacts);

/*
 * Does what pinch_ode_each_pair does with a near callback that hands over what it finds, to the same bits, and has
 * `near` look at pairs of geoms in all threads (settings.threads). most >= 1: contacts of a pair. Contacts are between
 * the geoms' bodies. The geoms of an inner space are met by those outside of it, and not by each other. Geoms that need
 * ODE's data of a thread, as trimeshes do, have it. Beside height fields, one thread looks at all pairs, as ODE moves
 * what these meet while they collide. Where it does not return PINCH_OK, some contacts have not been handed over.
 */
PINCH_API pinch_status pinch_ode_collide(pinch_ode *plugin, dSpaceID space, int most, pinch_ode_near near,
                                         void *context);

/*
 * Does what pinch_ode_add_contact does for a program that has made its contact a contact joint of ODE's, from *contact,
 * and attached it: where Pinch solves the contact, the joint is disabled while ODE steps, and its feedback, if it has
 * one, gets Pinch's force; where not, the joint is left to ODE as it is. The joint must live until the step is done; it
 * is handed over again for every step in which it is to count.
 */
PINCH_API pinch_status pinch_ode_add_joint(pinch_ode *plugin, dJointID joint, const dContact *contact);

/*
 * Hands over a body for its joints: in this step, the island that they tie it into is solved even where nothing touches
 * it. Otherwise only joints beside contacts are. Of islands without contacts Pinch solves those whose joints are all
 * known: under quickstep, whose sweeps leave joints torn apart, and under worldstep, which solves joints exactly, where
 * they close loops, whose errors of position it takes back whatever energy that puts in, or have more than 60 rows,
 * which its direct method takes long for. The drop-in layer hands over all bodies with joints. Not to be called between
 * pinch_ode_solve and pinch_ode_advance.
 */
PINCH_API pinch_status pinch_ode_add_body(pinch_ode *plugin, dBodyID body);

/* Which of ODE's steps the next ones run; see pinch_ode_settings.stepper. */
PINCH_API pinch_status pinch_ode_set_stepper(pinch_ode *plugin, pinch_ode_stepper stepper);

/*
 * Tells how many bodies the world has, kinematic and disabled ones included; -1, as at first: nobody knows. In a step
 * in which Pinch moves all of them, or has them at rest, ODE's own step would only walk through its lists, and is left
 * out: a tenth of the step of one grasp, and the part of many grasps that threads do not share. To be called whenever
 * bodies have been made or destroyed. With a number below the world's, bodies that only ODE moves may stand still; with
 * one above it, ODE always steps. PINCH_INVALID_ARGUMENT for numbers below -1.
 */
PINCH_API pinch_status pinch_ode_set_body_count(pinch_ode *plugin, int count);

/*
 * One step of h seconds (> 0), instead of dWorldStep or dWorldQuickStep. Stiff contacts climb the ladder of compliance
 * floors first. An island that does not converge is tried again from no forces, with NSNMGK and Newton's steps and then
 * with Newton alone. If it has joints, it is tried once more with errors of their positions left as they are; after
 * that it is left to ODE's own contacts for this step. An answer in which joints or hard contacts put more energy in
 * than they may is not taken: the island is solved again, up to six times, with overlaps and errors of position taken
 * back more slowly. A solve has a budget by what ODE's own step takes (settings.solver.budget, where it is not 0,
 * instead): an island that goes over it is not tried again, and is left to ODE for 1 more step, then for 2, 4 and so
 * on. Where all bodies are free, and dWorldQuickStep steps or the island has more than 1,000 contacts, for which
 * dWorldStep takes 20 s, it is swept instead, also in these steps, of which there are 32 at most
 * (settings.solver.sweeps, where it is not 0, instead of as many sweeps as quickstep makes); so are large heaps that
 * sweeps would do for less work and as softly, and tall piles of more than 2,000 contacts before a solve would make
 * them softer. Piles higher than sweeps reach are split first (core/README.md, (74)). An island that has no answer two
 * steps in a row is left to ODE, or swept, for growing spans of steps, too. All of it is counted in the statistics. The
 * result says whether the call was legal; the statistics say how the solves ended. PINCH_INVALID_ARGUMENT also for
 * bodies in contact whose state or forces are not finite or overflow: ODE, which aborts on such numbers, is then not
 * stepped.
 */
PINCH_API pinch_status pinch_ode_step(pinch_ode *plugin, double h);

/* The two parts of pinch_ode_step, for programs that measure or change things between them: everything up to the
 * forces, then ODE's step and the contact histories. A force that is added between them to a body on joints is seen by
 * no solver where Pinch has found the joints' forces (see joints_by_ode). Both get the same h: forces that were found
 * for a step are not those of a longer one. PINCH_INVALID_ARGUMENT for another h, and where nothing has been solved;
 * the step can still be advanced by the right one. */
PINCH_API pinch_status pinch_ode_solve(pinch_ode *plugin, double h);
PINCH_API pinch_status pinch_ode_advance(pinch_ode *plugin, double h);

/* One contact point of the step just done. */
typedef struct pinch_ode_contact {
    dGeomID geom1, geom2;        /* NULL where the contact had none */
    dBodyID body1, body2;        /* NULL for the static world */
    double position[3];          /* m; where a material counts: on the surface of the geom without one, between two
                                  * by their compliances, but between flat faces where the collider puts it */
    double normal[3];            /* unit, into body 1 */
    double depth;                /* m, at the start of the step */
    double force[3];             /* on body 1, N; body 2 gets the opposite */
    double torsion;              /* moment on body 1 about the normal, N m */
    double rolling_moment[3];    /* moment of rolling friction on body 1, in the tangent plane, N m */
    double normal_force;         /* N */
    double tangential[3];        /* part of `force` in the tangent plane, N */
    double stiffness[3];         /* of this point: its share of the fingertip's */
    double elastic[3];           /* elastic tangential displacement, world, m, after the step */
    double twist;                /* elastic rotation about the normal, rad, after the step */
    double slip[3];              /* slip increment of the step, world, m; what presses without friction slips with all
                                  * of its tangential motion, and its state is PINCH_CONTACT_SLIP */
    double slip_twist;           /* rad */
    double relative_velocity[3]; /* of body 1 against body 2 at the point as solved, world, m/s */
    double spin;                 /* relative velocity about the normal, rad/s */
    double friction_limit;       /* the most that `tangential` can be, N: friction coefficient times normal force, for
                                  * example; the smaller one where the tangents' limits differ; 0 without friction */
    double torsion_limit;        /* the most that `torsion` can be, N m; 0 where the contact has none */
    pinch_contact_state state;   /* what presses without friction slips. Of an island left to ODE, whose forces alone
                                  * are known, all that presses is reported as sticking, with stiffness, slip,
                                  * relative velocity and limits 0 */
} pinch_ode_contact;

/* The contact points of the step just done, in a fixed order. Valid until the next call that takes `plugin`. */
PINCH_API pinch_status pinch_ode_contacts(const pinch_ode *plugin, const pinch_ode_contact **list, int *count);

/* What the contacts of a geom, or of a pair of geoms, exert together in the step just done. World axes. */
typedef struct pinch_ode_load {
    int points;                /* contact points that press */
    pinch_contact_state state; /* open: none presses; slip, yield: all that press do; otherwise stick */
    double force[3];           /* N, on the geom */
    double moment[3];          /* N m, on the geom, about the point that was asked for; torsion and rolling count */
    double position[3];        /* m: the mean of the points, each by its normal force; zero where none presses */
    double normal[3];          /* N: the part of `force` along the points' normals */
    double tangential[3];      /* N: the other part of `force`, which is friction */
    double normal_force;       /* N, >= 0: the points' normal forces added up as numbers */
    double torsion;            /* N m: the points' torsional moments added up, about normals into the geom */
    double slip_margin;  /* 1 - hypot(|tangential| / friction limit, torsion / torsional limit), the unused part of
                          * the limit of the pair's points together: 1 where the friction force is zero, 0 while the
                          * pair slips. Of a geom's pairs, the least. NaN where nothing presses and friction has no
                          * limit of its own, and where the friction coefficient is 0 */
    double least_margin; /* the same of the single point that is nearest to slipping */
    double slip_total;   /* m: length of the path that the pair has slipped since it touched; of a geom's pairs,
                          * the longest */
    double twist_total;  /* rad: the same about the normal */
} pinch_ode_load;

/*
 * Sums up the contacts of `geom` with everything, or with `partner` alone. Moments are about the point `about` (m,
 * world); with NULL about the centre of mass of the geom's body, or the world's origin where it has none. A geom that
 * touches nothing has a load of zeros, with margins NaN. Valid after pinch_ode_step, and between pinch_ode_solve and
 * pinch_ode_advance, where `slip_total` is still that of the last step. Contacts that were handed over without geoms
 * (the drop-in layer makes such) have no load here; pinch_ode_contacts lists them. PINCH_INVALID_ARGUMENT: a NULL
 * pointer, or a point that is not finite.
 */
PINCH_API pinch_status pinch_ode_geom_load(const pinch_ode *plugin, dGeomID geom, const double about[3],
                                           pinch_ode_load *load);
PINCH_API pinch_status pinch_ode_pair_load(const pinch_ode *plugin, dGeomID geom, dGeomID partner,
                                           const double about[3], pinch_ode_load *load);

/* What the contacts of the step just done did with energy, J. Each term is computed from its own forces and motions.
 * Rolling friction is left out. */
typedef struct pinch_ode_energy {
    double elastic_start; /* stored in the contacts as the step found them */
    double elastic_end;   /* stored when it left them */
    double friction;      /* lost to slip, >= 0 */
    double damping;       /* lost to the contacts' dampers and to shear that an opening contact lets go, >= 0 */
    double integrator; /* lost to the implicit step: a spring's force is that of its end over the whole motion, >= 0 */
    double drives;     /* work of the kinematic bodies and force-controlled drives on the others */
} pinch_ode_energy;

/* Of the islands that Pinch solved in the last step; zeros before the first. PINCH_INVALID_ARGUMENT between
 * pinch_ode_solve and pinch_ode_advance, and without settings.keep_islands. */
PINCH_API pinch_status pinch_ode_contact_energy(const pinch_ode *plugin, pinch_ode_energy *energy);

/* clang-format off */
/*
 * Tells what ODE keeps of a joint and has no getter for, so that the joint's forces can be Pinch's own (see
 * joints_by_ode). The drop-in layer sees the calls by itself; other programs call pinch_ode_note_joint when they have
 * made a joint, before its bodies move, and again when they have changed what the table names:
 *
 *     fixed                         dJointSetFixed
 *     slider, hinge-2               dJointSetSliderAxis, dJointSetHinge2Axes; dJointAttach
 *     hinge, piston                 the axis; dJointAttach
 *     double hinge                  the axis
 *     PR, PU                        anchor and axes; dJointAttach
 *     angular motor in Euler mode   mode and axes
 *     transmission                  anchors and axes
 *     plane-2D                      nothing: it is told once, and has no motors then
 *
 * PR, piston and Euler motor that are attached as (0, body) run away in ODE itself, by the sign of their errors or
 * stops; Pinch's own solve has the right one.
 *
 * A hinge that was not noted is found out from its angle within some steps; the others stay with ODE. Axes are to be
 * set as unit vectors, and offsets as those of dJointSetPUAnchorOffset along the prismatic axis.
 * PINCH_INVALID_ARGUMENT for joints of other types, of which ODE shows everything, and for one without bodies;
 * PINCH_OUT_OF_MEMORY, and then the joint stays with ODE.
 */
PINCH_API pinch_status pinch_ode_note_joint(pinch_ode *plugin, dJointID joint);
/* clang-format on */
/* The arguments of dJointSetLMotorAxis: axis 0 to 2, and its `rel`, the frame that it is fixed in: 0 for the world, 1
 * and 2 for the joint's bodies. A linear motor is Pinch's where all of its axes are told. */
PINCH_API pinch_status pinch_ode_note_linear_motor(pinch_ode *plugin, dJointID joint, int axis, int frame);
/* The arguments of dJointSetPlane2DXParam (motor 0), -YParam (1) and -AngleParam (2), after pinch_ode_note_joint. */
PINCH_API pinch_status pinch_ode_note_plane_motor(pinch_ode *plugin, dJointID joint, int motor, int parameter,
                                                  double value);

/* A spring and a damper on a coordinate of a joint, with a target and a bound: position control. */
typedef struct pinch_servo {
    double target;    /* rad or m */
    double kp;        /* N m/rad or N/m, >= 0 */
    double kd;        /* N m s/rad or N s/m, >= 0 */
    double rate;      /* rad/s or m/s: what the damper is at rest at; default 0 */
    double max_force; /* N m or N, > 0: the most that the servo exerts, either way; default INFINITY */
} pinch_servo;

PINCH_API pinch_servo pinch_default_servo(void);

/*
 * Puts a servo on coordinate `axis` of a joint, changes it, or ends it (NULL). Its force is
 *
 *     clamp(kp (target - q) + kd (rate - q'), -max_force, max_force)
 *
 * with q and q' of the end of the step, so that no gain is too high. At rest it is kp (target - q) exactly, and at its
 * bound exactly that. It acts beside the joint's own motors and stops, and is part of the joint's feedback. Coordinates
 * are as the joint's getters show them; an angle is followed over whole turns from where the servo was set, up to half
 * a turn in a step:
 *
 *     hinge, slider          0: angle, position
 *     universal, hinge-2     0 and 1: angle 1 and 2
 *     PU                     0 and 1: angle 1 and 2
 *     piston                 0: position, 1: angle
 *     PR                     1: angle
 *
 * It works under either stepper and without contacts, too. Where ODE solves the joint, it solves the same law as a
 * motor, as exactly as the stepper does. A disabled joint has no servo. It is to be ended before its joint is
 * destroyed. PINCH_INVALID_ARGUMENT for numbers out of range, for other joints and coordinates, and between
 * pinch_ode_solve and pinch_ode_advance; PINCH_OUT_OF_MEMORY.
 */
PINCH_API pinch_status pinch_ode_set_servo(pinch_ode *plugin, dJointID joint, int axis, const pinch_servo *servo);
/* The coordinate at the start of the last step, and the force (N or N m) that the servo has exerted in it.
 * PINCH_INVALID_ARGUMENT where there is no servo, or no step since it was set. */
PINCH_API pinch_status pinch_ode_servo_state(const pinch_ode *plugin, dJointID joint, int axis, double *position,
                                             double *force);

/* One coordinate of a coupling, as pinch_ode_set_servo has them. */
typedef struct pinch_coupling_term {
    dJointID joint; /* one of those that can have a servo */
    int axis;       /* its coordinate, as in pinch_ode_set_servo */
    double factor;  /* not 0 */
} pinch_coupling_term;

enum { PINCH_COUPLING_TERMS = 16 };

/*
 * Couples coordinates of joints: a servo on x = sum of factor times coordinate, over 1 to PINCH_COUPLING_TERMS terms.
 * It exerts
 *
 *     f = clamp(kp (target - x) + kd (rate - x'), -max_force, max_force),
 *
 * with x and x' of the end of the step, and factor times f on each coordinate: a fixed tendon with its actuator.
 * Factors are in m/rad and 1, say, and f in N then. With kp = INFINITY the coupling is rigid, x = target: a gear or a
 * mimic, which transmits up to max_force; kd and rate do not count, and an error of x is taken away in one step.
 * *coupling becomes its number.
 *
 * It works under either stepper and without contacts, too. It is not part of the joints' feedback. While one of its
 * joints is disabled it does not act. Rows of couplings are solved with the forces as unknowns: an island that has one
 * beside a body under force control (pinch_ode_set_drive), a linearized cone or a solver without Newton's steps is left
 * to ODE. ODE has no such row. In an island that is left to it, for whatever reason, f is what the row would take if
 * its bodies were free, within the bounds. That never takes x farther than asked for, but a tie is no longer held
 * exactly.
 *
 * It is to be ended before one of its joints is destroyed. PINCH_INVALID_ARGUMENT for numbers out of range, for other
 * joints and coordinates, and between pinch_ode_solve and pinch_ode_advance; PINCH_OUT_OF_MEMORY.
 */
PINCH_API pinch_status pinch_ode_couple(pinch_ode *plugin, const pinch_coupling_term *terms, int count,
                                        const pinch_servo *law, int *coupling);
/* Changes the law of a coupling, or ends it (NULL); its number may come back with another. PINCH_INVALID_ARGUMENT as
 * above and where there is none of this number. */
PINCH_API pinch_status pinch_ode_set_coupling(pinch_ode *plugin, int coupling, const pinch_servo *law);
/* x at the start of the last step, and the force f exerted in it. PINCH_INVALID_ARGUMENT where there is no coupling of
 * this number, or no step since it was made. */
PINCH_API pinch_status pinch_ode_coupling_state(const pinch_ode *plugin, int coupling, double *position, double *force);

/* Ends the contact history of a geom: call it before a geom is destroyed, re-shaped or moved by hand to another place.
 * The material stays; for a geom that is destroyed take it away first (pinch_ode_set_material with NULL), or the next
 * geom that ODE puts in the same place of memory has it. A space that is destroyed is a geom, too. */
PINCH_API pinch_status pinch_ode_forget_geom(pinch_ode *plugin, dGeomID geom);
/* Ends all that is kept of a body: call it before a body is destroyed. ODE may put the next one in the same place of
 * memory, where it would go on with the other's contacts, drive and pace: whether it does depends on what else the
 * program has in memory, and so would the results. PINCH_INVALID_ARGUMENT between pinch_ode_solve and
 * pinch_ode_advance; PINCH_OUT_OF_MEMORY, and then nothing is forgotten. */
PINCH_API pinch_status pinch_ode_forget_body(pinch_ode *plugin, dBodyID body);
/* The same for a joint that is no contact joint, its servos included. Its couplings are to be ended before. */
PINCH_API pinch_status pinch_ode_forget_joint(pinch_ode *plugin, dJointID joint);

/*
 * Between pinch_ode_solve and pinch_ode_advance: the islands of the step at hand, as plain data, for programs that
 * check or record them. What was solved for is filled in; where no solver found an answer, this is what the last one
 * that was tried ended with, which pinch_ode_read_outcome tells. places: of its contacts in the list of
 * pinch_ode_contacts; room for as many as that counts. PINCH_INVALID_ARGUMENT at other times, without
 * settings.keep_islands and for an island that is none.
 */
PINCH_API int pinch_ode_island_count(const pinch_ode *plugin);
PINCH_API pinch_status pinch_ode_read_island(const pinch_ode *plugin, int island, pinch_problem *problem, int *places);

/* What became of an island. Neither solved nor asleep: it is left to ODE. */
typedef struct pinch_ode_outcome {
    bool solved;              /* its forces are Pinch's, and verified unless result.swept */
    bool asleep;              /* all its bodies are disabled */
    bool reused;              /* it rested, and its answer is the last step's */
    bool tried;               /* a solver worked on it in this step */
    bool first_solve_failed;  /* the solver asked for did not solve it, whatever solved it later */
    pinch_step_result result; /* of the last solver that was tried in this step; all zero where none was */
} pinch_ode_outcome;

/* As pinch_ode_read_island, with or without settings.keep_islands. */
PINCH_API pinch_status pinch_ode_read_outcome(const pinch_ode *plugin, int island, pinch_ode_outcome *outcome);

/* Writes a recording as a JSON document of the format "pinch-island/1" (assets/schema/pinch-island-1.json), which
 * `pinch replay` solves again. Every number reads back as the same bits. Returns false where it could not be written.
 */
PINCH_API bool pinch_ode_write_recording(const pinch_ode_recording *recording, FILE *stream);

/* A folder that recordings are written into, as island-000001.json and so on; files that are there already stay. */
typedef struct pinch_ode_record_folder {
    const char *path; /* has to be there, and to stay */
    int most;         /* recordings, >= 0; those that follow are not written */
    int written;      /* out, 0 at first */
    int last;         /* the last number tried, 0 at first */
    bool failed;      /* out: one could not be written, and none was after it */
} pinch_ode_record_folder;

/* A recorder whose context is a pinch_ode_record_folder. Calls from several threads take turns. */
PINCH_API void pinch_ode_record_into_folder(void *folder, const pinch_ode_recording *recording);

/* Counts and extremes since the plugin was made, or reset. */
typedef struct pinch_ode_stats {
    long steps;                  /* done */
    long contacts_solved;        /* points of manifolds, summed over steps: fewer than contacts handed over where many
                                  * are reduced, more where points stay that the collider does not return */
    long contacts_left;          /* to ODE's own solver; the sum of the three below */
    long contacts_left_by_scope; /* outside settings.scope */
    long contacts_left_unsupported; /* surface parameters that Pinch has no law for, or no method with these settings */
    long contacts_left_unsolved;    /* of islands that no solver solved, or whose joints ODE solves too coarsely */
    long islands_at_rest;    /* islands that nothing had changed, to the bit: the last step's answer was given again */
    long contacts_asleep;    /* between bodies all of which are disabled; nobody solves them */
    long contacts_malformed; /* skipped */
    long islands;            /* solved, summed over steps */
    long unconverged_steps;  /* steps in which an island's first solve failed, an island's contacts were left to ODE, or
                              * an island's answer was too soft or that of sweeps that were not verified */
    long retried_islands;    /* solved by a later try */
    long fallback_islands;   /* solved by ODE's own contacts for a step */
    long backoffs;           /* spans of steps for which an island that went wrong was left to ODE without a try */
    long softened_islands;   /* solved with more compliance than prescribed, because they are stiff */
    long too_soft_islands;   /* of these, with so much more that they do not count as converged, see pinch_step_result;
                              * the bodies get the forces all the same */
    long
        swept_islands; /* approximated by splitting and Gauss-Seidel sweeps, as a solve would take too long: those whose
                        * forces the check does not let pass count as not converged; the bodies get them all the same */
    long drives_at_limit;      /* bodies under force control that went as far as they may in a step, because no contact
                                * bore their force; summed over steps */
    int floor_level_max;       /* highest level of the ladder of compliance floors; 0 is the first */
    double floor_depth_max;    /* m: the most that a floor's compliance lets a contact sink beyond the prescribed one */
    double floor_residual_max; /* N: the most by which it has a normal force miss the prescribed law */
    long iterations;           /* summed over islands, sweeps included */
    int iterations_max;        /* of one island */
    long projections, newton_steps; /* of the solvers, summed over islands */
    long islands_by_projections;    /* islands whose answer was found by greedy projections (Newton's steps may have
                                     * helped); the four are summed over steps, and of the other islands the start was
                                     * the answer, or they were swept */
    long islands_by_newton;         /* by Newton's steps alone */
    long islands_by_flow;           /* by an implicit flow or a path of solutions, where those did not get there */
    long islands_by_lcp;            /* by Lemke's method or projected Gauss-Seidel */
    double residual_max;            /* see pinch_step_result, over all islands and steps */
    double cone, complementarity, slip_direction; /* N, likewise */
    double force_scale;                           /* largest contact force, N */
    double
        step_mismatch; /* largest difference between a velocity solved for and the one ODE arrived at, m/s (linear) */
    double step_mismatch_angular; /* rad/s */
    double depth_max;             /* m */
    double joint_error_max;       /* m: how far joints of solved islands have come apart, along the row that is furthest
                                   * off; stops and suspensions do not count */
    double joint_error_angle_max; /* rad: how far their bodies are turned from where they hold them, likewise, as rows
                                   * measure it: the sine about an axis that a joint leaves, twice that of half the
                                   * angle where it leaves none */
    long joints_unmodelled;       /* joints of contacting bodies whose type has no rows here, summed over steps */
    long joints_solved;           /* joints whose forces were Pinch's own, summed over steps */
    long joints_left;             /* joints of solved islands that ODE solved, see joints_by_ode; summed over steps */
    int points_high_water;        /* contact points in one step */
    size_t memory;                /* bytes held */
} pinch_ode_stats;

PINCH_API pinch_ode_stats pinch_ode_statistics(const pinch_ode *plugin);
PINCH_API void pinch_ode_reset_statistics(pinch_ode *plugin);

/*
 * ---- snapshots ----
 *
 * Contacts carry state from step to step: elastic shear, the points that a manifold keeps, the forces that a solve
 * starts from. Positions and velocities alone do not bring a grasp back. A snapshot has all that the next step depends
 * on: contact histories, materials, drives, servos, couplings, what was noted of joints, spans of back-off,
 * statistics; and of the world the pose, velocity, force and enabled state of each body, the poses of geoms
 * without a body, the order of geoms in simple and hash spaces and of
 * pinch_ode_each_pair, and the seed of ODE's random numbers.
 *
 * It is restored into the same world, or into another one that was built in the same way, also in another process. A
 * world that was restored, and the one that went on after it was saved, do the same from there, to the bit. What the
 * program sets itself has to be set again as it was: gravity, ERP, CFM, masses, parameters of joints, targets of paths.
 * What ODE keeps and does not show begins anew: how long bodies have been slow whose joints ODE solves and that touch
 * nothing, and the angles that transmissions and angular motors in Euler mode follow.
 */

/* The things of a world in an order that the program can repeat: all bodies, geoms and joints that contacts, servos,
 * couplings and drives are of. None may be NULL or come twice. */
typedef struct pinch_ode_parts {
    const dBodyID *bodies;                   /* body_count of them */
    const dGeomID *geoms;                    /* geom_count of them */
    const dJointID *joints;                  /* joint_count of them */
    int body_count, geom_count, joint_count; /* >= 0; a list may be NULL where there are none */
} pinch_ode_parts;

/*
 * Writes a snapshot to `data`, which has room for *size bytes, and sets *size to the bytes it takes; `data` NULL only
 * asks for these. The world goes on as if nothing had been saved, but that its
 * simple and hash spaces look at the geoms that have moved (dSpaceClean).
 *
 * To be called between steps, before contacts and bodies are handed over. PINCH_INVALID_ARGUMENT at other times, where
 * there is too little room, and where something that is in use is not among the parts; PINCH_OUT_OF_MEMORY.
 */
PINCH_API pinch_status pinch_ode_save(pinch_ode *plugin, const pinch_ode_parts *parts, void *data, size_t *size);

/*
 * Brings plugin and world into the state of a snapshot of `size` bytes. The parts are to correspond to those it was
 * saved with, one by one. The settings are the plugin's own: the same ones go on to the same bits.
 *
 * PINCH_INVALID_ARGUMENT between pinch_ode_solve and pinch_ode_advance, once contacts or bodies are handed over, and
 * for data that are no whole snapshot of this format and byte order with as many parts; PINCH_OUT_OF_MEMORY. Plugin and
 * world are then as before.
 */
PINCH_API pinch_status pinch_ode_restore(pinch_ode *plugin, const pinch_ode_parts *parts, const void *data,
                                         size_t size);

#ifdef __cplusplus
}
#endif
#endif
