/* Reading a hand file by its root element; what is asked about a hand. */

#include "hand.h"

#include "formats.h"
#include "reader.h"

#include <stdio.h>
#include <stdlib.h>

void hand_free(hand *h)
{
    if (!h) return;
    for (size_t i = 0; i < h->tendon_count; i++) {
        free(h->tendons[i].joints);
        free(h->tendons[i].coefficients);
    }
    for (size_t i = 0; i < h->mesh_count; i++) mesh_hull_free(&h->meshes[i].hull);
    for (size_t i = 0; i < h->text_count; i++) free(h->texts[i]);
    void *lists[] = {h->links, h->bodies, h->joints,   h->couplings, h->tendons,    h->drives, h->loops,
                     h->geoms, h->meshes, h->excludes, h->ignored,   h->unmodelled, h->texts,  h->files};
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) free(lists[i]);
    free(h);
}

hand_status hand_load(const char *file, const hand_package *packages, size_t package_count, hand **h, hand_error *error)
{
    hand_reader r = {.packages = packages, .package_count = package_count, .error = error};
    *h = NULL;
    error->text[0] = '\0';
    r.h = calloc(1, sizeof *r.h);
    if (!r.h) {
        snprintf(error->text, sizeof error->text, "%.300s: out of memory", file);
        return HAND_NO_MEMORY;
    }
    r.h->file = reader_text(&r, "%s", file);
    r.names = xmlHashCreate(0);
    if (!r.names) reader_no_memory(&r);
    xmlDoc *document = reader_document(&r, NULL, file);
    xmlNode *root = document ? xmlDocGetRootElement(document) : NULL;
    if (root && xml_is(root, "robot"))
        urdf_read(&r, root);
    else if (root && xml_is(root, "mujoco"))
        mjcf_read(&r, root);
    else if (root)
        reader_refuse(&r, root, "expected a root element <robot> (URDF) or <mujoco> (MJCF)");
    tree_complete(&r);
    xmlFreeDoc(document);
    if (r.names) xmlHashFree(r.names, NULL);
    if (r.status == HAND_OK)
        *h = r.h;
    else
        hand_free(r.h);
    return r.status;
}

int hand_find_joint(const hand *h, const char *name)
{
    for (size_t i = 0; i < h->joint_count; i++)
        if (strcmp(h->joints[i].name, name) == 0) return (int)i;
    return -1;
}

int hand_find_link(const hand *h, const char *name)
{
    for (size_t i = 0; i < h->link_count; i++)
        if (strcmp(h->links[i].name, name) == 0) return (int)i;
    return -1;
}

double hand_total_mass(const hand *h)
{
    double sum = 0;
    for (size_t i = 0; i < h->link_count; i++) sum += h->links[i].mass.mass;
    return sum;
}

int hand_tip_of(const hand *h, size_t body)
{
    int tip = -1;
    for (size_t i = 0; i < h->body_count; i++)
        if (body == 0 || h->bodies[i].parent == (int)body) return -1;
    for (size_t i = 0; i < h->geom_count; i++)
        if (h->geoms[i].collides && h->geoms[i].body == (int)body && h->geoms[i].link > tip) tip = h->geoms[i].link;
    return tip;
}
