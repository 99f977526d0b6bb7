/* Where the links are for given positions of the joints. */

#include "hand.h"

#include <stdlib.h>

/* Moves `frame`, the frame of the joint's link in that of the hand, by the joint. A hinge leaves its anchor in place.
 */
static void move(const hand_joint *joint, double position, hand_pose *frame)
{
    double way = position - joint->reference;
    if (joint->type == HAND_SLIDER) {
        double axis[3];
        scene_rotate(frame->orientation, joint->axis, axis);
        scene_add_scaled(frame->position, way, axis);
        return;
    }
    double anchor[3], arm[3], turn[4], rotation[3], turned[4];
    pose_point(frame, joint->anchor, anchor);
    for (int i = 0; i < 3; i++) rotation[i] = way * joint->axis[i];
    scene_quaternion_from_rotation(rotation, turn);
    scene_quaternion_product(frame->orientation, turn, turned);
    pose_normalize(turned);
    memcpy(frame->orientation, turned, sizeof turned);
    scene_rotate(frame->orientation, joint->anchor, arm);
    scene_subtract(anchor, arm, frame->position);
}

void hand_kinematics(const hand *h, const double *positions, hand_pose *links)
{
    size_t next = 0; /* joints are in the order of their links */
    for (size_t i = 0; i < h->link_count; i++) {
        const hand_link *link = &h->links[i];
        links[i] = link->parent < 0 ? link->pose : pose_product(&links[link->parent], &link->pose);
        for (; next < h->joint_count && h->joints[next].link == (int)i; next++)
            move(&h->joints[next], positions[next], &links[i]);
    }
}

void hand_follow_couplings(const hand *h, const bool *given, double *positions)
{
    /* A coupled joint may follow a coupled joint; the reader has refused circles, so the longest chain has as many
     * couplings as there are. */
    bool moved = true;
    for (size_t pass = 0; pass < h->coupling_count && moved; pass++) {
        moved = false;
        for (size_t k = 0; k < h->coupling_count; k++) {
            const hand_coupling *c = &h->couplings[k];
            double position = c->offset + (c->of < 0 ? 0 : c->multiplier * positions[c->of]);
            if (given[c->joint] || positions[c->joint] == position) continue;
            positions[c->joint] = position;
            moved = true;
        }
    }
}

static bool hangs_from(const hand *h, int body, int from)
{
    while (body > from) body = h->bodies[body].parent;
    return body == from;
}

/* The link's own inertia about an axis through a point, in the frame of the hand. */
static double inertia_about(const hand_link *link, const hand_pose *pose, const double axis[3], const double point[3])
{
    double own[3], centre[3], arm[3], off[3], sum = 0;
    scene_rotate_back(pose->orientation, axis, own);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) sum += own[i] * link->mass.inertia[3 * i + j] * own[j];
    pose_point(pose, link->mass.centre, centre);
    scene_subtract(centre, point, arm);
    scene_cross(axis, arm, off);
    return sum + link->mass.mass * scene_dot(off, off);
}

double hand_moved_inertia(const hand *h, int joint)
{
    const hand_joint *of = &h->joints[joint];
    hand_pose *links = calloc(h->link_count + 1, sizeof *links);
    double *positions = calloc(h->joint_count + 1, sizeof *positions), sum = of->armature, axis[3], anchor[3];
    for (size_t i = 0; positions && i < h->joint_count; i++) positions[i] = h->joints[i].reference;
    if (links && positions) {
        hand_kinematics(h, positions, links);
        scene_rotate(links[of->link].orientation, of->axis, axis);
        pose_point(&links[of->link], of->anchor, anchor);
    }
    for (size_t i = 0; links && positions && i < h->link_count; i++) {
        const hand_link *link = &h->links[i];
        if (!hangs_from(h, link->body, of->body)) continue;
        sum += of->type == HAND_SLIDER ? link->mass.mass : inertia_about(link, &links[i], axis, anchor);
    }
    free(links);
    free(positions);
    return sum;
}
