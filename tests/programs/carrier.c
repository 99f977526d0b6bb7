/* Steps a world of an ODE in single precision, which a library of its own carries. It ends with 0 where every number
 * arrives there as it was. */
void *dWorldCreate(void);
void dWorldDestroy(void *world);
int dWorldStep(void *world, float h);
void *dCreateBox(void *space, float x, float y, float z);

int main(void)
{
    void *world = dWorldCreate();
    if (dCreateBox(world, 0.1F, 2.5e-30F, -7.0F) != world) return 1;
    int stepped = dWorldStep(world, 0.01F);
    dWorldDestroy(world);
    return stepped ? 0 : 1;
}
