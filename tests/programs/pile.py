"""A few boxes and a sphere in a Python program: prints how they rest. Needs python3-pyode."""

import json
import sys

import ode

STEPS, LAST, H = int(sys.argv[1]) if len(sys.argv) > 1 else 1500, 500, 0.01


def near(_, geom1, geom2):
    for contact in ode.collide(geom1, geom2):
        contact.setMode(ode.ContactApprox1)
        contact.setMu(0.5)
        joint = ode.ContactJoint(world, group, contact)
        joint.attach(geom1.getBody(), geom2.getBody())


def body(geom, mass, place):
    b = ode.Body(world)
    b.setMass(mass)
    b.setPosition(place)
    geom.setBody(b)
    return b


world = ode.World()
world.setGravity((0, 0, -9.81))
space = ode.Space()
group = ode.JointGroup()
ground = ode.GeomPlane(space, (0, 0, 1), 0)
geoms, bodies = [], []
for k in range(4):
    mass = ode.Mass()
    mass.setBoxTotal(1, 0.4, 0.4, 0.4)
    geoms.append(ode.GeomBox(space, (0.4, 0.4, 0.4)))
    bodies.append(body(geoms[-1], mass, (0, 0, 0.2 + 0.41 * k)))
mass = ode.Mass()
mass.setSphereTotal(1, 0.2)
geoms.append(ode.GeomSphere(space, 0.2))
bodies.append(body(geoms[-1], mass, (2, 0, 0.3)))

speed = 0.0
for step in range(STEPS):
    space.collide(None, near)
    if len(sys.argv) > 2 and sys.argv[2] == "world":
        world.step(H)
    else:
        world.quickStep(H)
    group.empty()
    if step >= STEPS - LAST:
        speed = max([speed] + [sum(v * v for v in b.getLinearVel()) ** 0.5 for b in bodies])
heights = [b.getPosition()[2] for b in bodies]
print(json.dumps({"program": "pile.py", "steps": STEPS, "speed_last": speed, "heights": heights,
                  "finite": all(h == h and abs(h) < 1e3 for h in heights)}))
