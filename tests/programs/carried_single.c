/* Stands for an ODE in single precision, as far as carrier.c needs one. */
#include <stddef.h>
#include <string.h>

void *dWorldCreate(void);
void dWorldDestroy(void *world);
int dWorldStep(void *world, float h);
void *dCreateBox(void *space, float x, float y, float z);
int dCheckConfiguration(const char *token);

static float got[4];

int dCheckConfiguration(const char *token)
{
    return strcmp(token, "ODE_single_precision") == 0;
}

void *dWorldCreate(void)
{
    return got;
}

void *dCreateBox(void *space, float x, float y, float z)
{
    got[0] = x, got[1] = y, got[2] = z;
    return space;
}

int dWorldStep(void *world, float h)
{
    (void)world;
    got[3] = h;
    return got[0] == 0.1F && got[1] == 2.5e-30F && got[2] == -7.0F && got[3] == 0.01F;
}

void dWorldDestroy(void *world)
{
    memset(world, 0, sizeof got);
}
