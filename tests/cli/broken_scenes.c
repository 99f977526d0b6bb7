#include "cli/broken_scenes.h"

const char good_scene[] =
    "{\n"
    "  \"format\": \"pinch-scene/1\",\n"
    "  \"name\": \"good\",\n"
    "  \"gravity\": [0, 0, -9.81],\n"
    "  \"object\": {\n"
    "    \"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]},\n"
    "    \"mass\": 0.5,\n"
    "    \"position\": [0, 0, 0],\n"
    "    \"orientation\": [1, 0, 0, 0]\n"
    "  },\n"
    "  \"fingers\": [\n"
    "    {\n"
    "      \"name\": \"left\",\n"
    "      \"point\": [-0.05, 0, 0],\n"
    "      \"normal\": [1, 0, 0],\n"
    "      \"tangent\": [0, 1, 0],\n"
    "      \"tip\": {\"type\": \"sphere\", \"radius\": 0.01},\n"
    "      \"model\": \"soft\",\n"
    "      \"stiffness\": {\"normal\": 20000, \"tangential\": 10000, \"torsional\": 1.5},\n"
    "      \"damping\": {\"normal\": 20, \"tangential\": 10},\n"
    "      \"friction\": {\"static\": 0.5, \"kinetic\": 0.4},\n"
    "      \"torsional_friction\": 0.002,\n"
    "      \"closing\": 0.0005,\n"
    "      \"ramp\": 0.25,\n"
    "      \"max_force\": 50,\n"
    "      \"damage\": {\"max_force\": 30, \"max_slip\": 0.001}\n"
    "    },\n"
    "    {\n"
    "      \"name\": \"right\",\n"
    "      \"point\": [0.05, 0, 0],\n"
    "      \"normal\": [-1, 0, 0],\n"
    "      \"model\": \"hard\",\n"
    "      \"stiffness\": {\"normal\": 30000},\n"
    "      \"friction\": 0.6,\n"
    "      \"drive\": {\"type\": \"slider\", \"mass\": 0.1, \"force\": 12, \"gravity\": false}\n"
    "    },\n"
    "    {\n"
    "      \"name\": \"top\",\n"
    "      \"point\": [0, 0, 0.05],\n"
    "      \"normal\": [0, 0, -1],\n"
    "      \"model\": \"frictionless\",\n"
    "      \"stiffness\": {\"normal\": 40000},\n"
    "      \"drive\": {\"type\": \"path\", \"points\": [\n"
    "        {\"time\": 0},\n"
    "        {\"time\": 1, \"translation\": [0, 0, 0.01]}\n"
    "      ]}\n"
    "    }\n"
    "  ],\n"
    "  \"environment\": [\n"
    "    {\"name\": \"table\", \"shape\": {\"type\": \"cylinder\", \"radius\": 1, \"length\": 0.2},\n"
    "     \"position\": [0, 0, -0.15], \"stiffness\": {\"normal\": 1e5}, \"friction\": 0.7}\n"
    "  ],\n"
    "  \"schedule\": [\n"
    "    {\"time\": 0, \"gravity\": [0, 0, 0]},\n"
    "    {\"time\": 0.5, \"gravity\": [0, 0, -9.8], \"hand\": {\"translation\": [0, 0, 0]}},\n"
    "    {\"time\": 1.5, \"force\": {\"amplitude\": [1, 0, 0], \"frequency\": 10, \"fade\": 1}}\n"
    "  ],\n"
    "  \"simulation\": {\"step\": 0.001, \"duration\": 2.5},\n"
    "  \"solver\": {\"name\": \"nsnmgk\", \"tolerance\": 1e-9, \"max_iterations\": 100, \"pyramid_faces\": 8}\n"
    "}\n";

const char good_plane[] = "{\n"
                          "  \"format\": \"pinch-scene/1\",\n"
                          "  \"dimension\": 2,\n"
                          "  \"gravity\": [0, -9.81, 0],\n"
                          "  \"object\": {\n"
                          "    \"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]},\n"
                          "    \"mass\": 0.5,\n"
                          "    \"position\": [0, 0, 0],\n"
                          "    \"orientation\": [1, 0, 0, 0],\n"
                          "    \"force\": [1, 0, 0],\n"
                          "    \"torque\": [0, 0, 1]\n"
                          "  },\n"
                          "  \"fingers\": [\n"
                          "    {\n"
                          "      \"point\": [-0.05, 0, 0],\n"
                          "      \"normal\": [1, 0, 0],\n"
                          "      \"model\": \"frictionless\",\n"
                          "      \"stiffness\": {\"normal\": 20000}\n"
                          "    }\n"
                          "  ],\n"
                          "  \"schedule\": [\n"
                          "    {\"time\": 1, \"base_acceleration\": [0, 0, 0]}\n"
                          "  ]\n"
                          "}\n";

#define SHAPE "{\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}"
#define TIP   "{\"type\": \"sphere\", \"radius\": 0.01}"

const broken_scene broken_scenes[] = {
    /* the document */
    {"cut off", good_scene, "8}\n}\n", "8", "\"solver\"", "solver.pyramid_faces", "valid JSON"},
    {"comma missing", good_scene, "\"mass\": 0.5,", "\"mass\": 0.5", "\"position\"", "object.mass", "valid JSON"},
    {"trailing comma", good_scene, "[1, 0, 0, 0]\n", "[1, 0, 0, 0],\n", "  },\n  \"fingers\"", "object", "valid JSON"},
    {"a zero character", good_scene, "\"good\"", "\"go\\u0000d\"", "go\\u0000d", "name",
     "valid JSON: the character \\u0000 may not stand in a text or a key\n"},
    {"a zero character in a key", good_scene, "\"closing\"", "\"clos\\u0000ing\"", "clos\\u0000ing",
     "fingers[0].clos\\u0000ing", "valid JSON: the character \\u0000 may not stand in a text or a key\n"},
    {"NaN", good_scene, "0.5,", "NaN,", "NaN", "object.mass", "valid JSON"},
    {"number too large", good_scene, "0.5,", "1e999,", "1e999", "object.mass", "a finite number"},
    {"whole number too large", good_scene, "[0, 0, 0.01]", "[0, 0, 1e309]", "1e309",
     "fingers[2].drive.points[1].translation[2]", "a finite number"},
    {"duplicate key", good_scene, "\"max_force\": 50,", "\"max_force\": 50,\n      \"ramp\": 1,", "\"ramp\": 1,",
     "fingers[0].ramp", "each key once"},
    {"top level a list", good_scene, good_scene, "[\n]\n", "[", "(top level)", "an object"},
    {"unknown key at the top", good_scene, "\"name\": \"good\"", "\"nmae\": \"good\"", "nmae", "nmae", "a known key"},
    {"unknown key in a finger", good_scene, "\"closing\"", "\"closng\"", "closng", "fingers[0].closng", "a known key"},
    {"unknown key in a shape", good_scene, SHAPE, "{\"type\": \"box\", \"size\": [1, 1, 1], \"radius\": 1}", "radius",
     "object.shape.radius", "a known key (type, size or rounding)"},
    {"format missing", good_scene, "  \"format\": \"pinch-scene/1\",\n", "", "{", "format", "key is missing"},
    {"format of another version", good_scene, "scene/1", "scene/2", "scene/2", "format", "pinch-scene/1"},
    {"name not a text", good_scene, "\"good\"", "7", "\"name\"", "name", "a text"},
    {"dimension 4", good_plane, "\"dimension\": 2", "\"dimension\": 4", "\"dimension\"", "dimension",
     "a whole number from 2 to 3"},

    /* the object */
    {"object missing", good_scene, good_scene, "\n{\"format\": \"pinch-scene/1\", \"fingers\": []}\n", "{", "object",
     "key is missing"},
    {"mass missing", good_scene, "    \"mass\": 0.5,\n", "", "\"object\"", "object.mass", "key is missing"},
    {"mass zero", good_scene, "\"mass\": 0.5", "\"mass\": 0", "\"mass\"", "object.mass", "a number > 0 (kg), got 0"},
    {"mass a text", good_scene, "\"mass\": 0.5", "\"mass\": \"0.5\"", "\"mass\"", "object.mass", "got \"0.5\""},
    {"unknown shape", good_scene, "\"box\"", "\"cube\"", "cube", "object.shape.type", "box, sphere, capsule"},
    {"rounding not below half the size", good_scene, SHAPE,
     "{\"type\": \"box\", \"size\": [0.1, 0.1, 0.02], \"rounding\": 0.01}", "rounding", "object.shape.rounding",
     "a rounding below 0.01 m, half of the least measure, got 0.01"},
    {"rounding negative", good_scene, SHAPE,
     "{\"type\": \"cylinder\", \"radius\": 1, \"length\": 1, \"rounding\": -0.1}", "rounding", "object.shape.rounding",
     "a number >= 0 (m), got -0.1"},
    {"rounding of a sphere", good_scene, SHAPE, "{\"type\": \"sphere\", \"radius\": 1, \"rounding\": 0.1}", "rounding",
     "object.shape.rounding", "a known key (type or radius)"},
    {"exponent out of range", good_scene, SHAPE,
     "{\"type\": \"superellipsoid\", \"radii\": [1, 1, 1], \"exponents\": [0.5, 1.7]}", "exponents",
     "object.shape.exponents[1]", "a number from 0.25 to 1.6, got 1.7"},
    {"one exponent", good_scene, SHAPE, "{\"type\": \"superellipsoid\", \"radii\": [1, 1, 1], \"exponents\": [1]}",
     "exponents", "object.shape.exponents", "2 numbers"},
    {"flat capsule without length", good_scene, SHAPE, "{\"type\": \"flat_capsule\", \"radius\": 1}", "shape",
     "object.shape.length", "key is missing"},
    {"shape's type missing", good_scene, SHAPE, "{\"size\": [1, 1, 1]}", "\"shape\"", "object.shape.type",
     "key is missing"},
    {"mesh", good_scene, SHAPE, "{\"type\": \"mesh\", \"file\": \"not-there.obj\"}", "mesh", "object.shape.file",
     "usable mesh"},
    {"box of negative size", good_scene, "[0.1, 0.1, 0.1]", "[0.1, -0.1, 0.1]", "\"shape\"", "object.shape.size[1]",
     "a number > 0 (m), got -0.1"},
    {"box of two sizes", good_scene, "[0.1, 0.1, 0.1]", "[0.1, 0.1]", "\"shape\"", "object.shape.size",
     "a list of 3 numbers (m), got a list of 2"},
    {"convex with three vertices", good_scene, SHAPE,
     "{\"type\": \"convex\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}", "\"shape\"", "object.shape.vertices",
     "at least 4 vertices"},
    {"flat convex", good_scene, SHAPE,
     "{\"type\": \"convex\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}", "\"shape\"",
     "object.shape.vertices", "vertices that span a volume"},
    {"vertex of a convex with two numbers", good_scene, SHAPE,
     "{\"type\": \"convex\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0],\n [1, 1]]}", "[1, 1]",
     "object.shape.vertices[3]", "a list of 3 numbers"},
    {"clockwise prism", good_scene, SHAPE,
     "{\"type\": \"prism\", \"height\": 1, \"vertices\": [[0, 0], [0, 1], [1, 0]]}", "\"shape\"",
     "object.shape.vertices", "counter-clockwise"},
    {"dented prism", good_scene, SHAPE,
     "{\"type\": \"prism\", \"height\": 1, \"vertices\": [[0, 0], [2, 0], [0.5, 0.5], [0, 2]]}", "\"shape\"",
     "object.shape.vertices", "strictly convex"},
    {"zero quaternion", good_scene, "[1, 0, 0, 0]", "[0, 0, 0, 0]", "\"orientation\"", "object.orientation",
     "not zero"},
    {"position of two numbers", good_scene, "\"position\": [0, 0, 0]", "\"position\": [0, 0]", "\"position\"",
     "object.position", "a list of 3 numbers (m)"},

    /* fingers */
    {"no fingers", good_plane, "\"fingers\": [", "\"fingers\": [], \"environment\": [", "\"fingers\"", "fingers",
     "at least one finger"},
    {"fingers an object", good_plane, "\"fingers\": [", "\"fingers\": {}, \"environment\": [", "\"fingers\"", "fingers",
     "a list of fingers, got an object"},
    {"finger a number", good_scene, "\"fingers\": [\n", "\"fingers\": [\n 3,\n", " 3,", "fingers[0]",
     "an object, got 3"},
    {"point missing", good_scene, "      \"point\": [0.05, 0, 0],\n", "", "    {\n      \"name\": \"right\"",
     "fingers[1].point", "key is missing"},
    {"point off the surface", good_scene, "[0.05, 0, 0]", "[0.06, 0, 0]", "[0.06", "fingers[1].point",
     "a gap of 0.01 m outside"},
    {"point inside", good_scene, "[0.05, 0, 0]", "[0.049, 0, 0]", "[0.049", "fingers[1].point",
     "a gap of 0.001 m inside"},
    {"point with a text in it", good_scene, "[0.05, 0, 0]", "[0.05,\n \"zero\", 0]", "zero", "fingers[1].point[1]",
     "a number (m), got \"zero\""},
    {"zero normal", good_scene, "[-1, 0, 0]", "[0, 0, 0]", "\"normal\": [0, 0, 0]", "fingers[1].normal", "not zero"},
    {"normal out of the object", good_scene, "[-1, 0, 0]", "[1, 0, 0.5]", "[1, 0, 0.5]", "fingers[1].normal",
     "points into the object"},
    {"normal along the surface", good_scene, "[-1, 0, 0]", "[0, 1, 0]", "\"normal\": [0, 1, 0]", "fingers[1].normal",
     "points into the object"},
    {"tangent along the normal", good_scene, "\"tangent\": [0, 1, 0]", "\"tangent\": [2, 0, 0]", "\"tangent\"",
     "fingers[0].tangent", "not parallel to the normal"},
    {"zero tangent", good_scene, "\"tangent\": [0, 1, 0]", "\"tangent\": [0, 0, 0]", "\"tangent\"",
     "fingers[0].tangent", "not zero"},
    {"tip of zero radius", good_scene, TIP, "{\"type\": \"sphere\", \"radius\": 0}", "\"tip\"", "fingers[0].tip.radius",
     "a number > 0 (m), got 0"},
    {"zero orientation of a tip", good_scene, "\"radius\": 0.01}", "\"radius\": 0.01, \"orientation\": [0, 0, 0, 0]}",
     "\"tip\"", "fingers[0].tip.orientation", "not zero"},
    {"model missing", good_scene, "      \"model\": \"hard\",\n", "", "    {\n      \"name\": \"right\"",
     "fingers[1].model", "key is missing"},
    {"unknown model", good_scene, "\"hard\"", "\"rubber\"", "rubber", "fingers[1].model",
     "frictionless, hard or soft, got \"rubber\""},
    {"stiffness missing", good_scene, "      \"stiffness\": {\"normal\": 30000},\n", "",
     "    {\n      \"name\": \"right\"", "fingers[1].stiffness", "key is missing"},
    {"stiffness a number", good_scene, "{\"normal\": 30000}", "30000", "30000", "fingers[1].stiffness",
     "an object, got 30000"},
    {"normal stiffness missing", good_scene, "{\"normal\": 30000}", "{\"tangential\": 30000}", "30000",
     "fingers[1].stiffness.normal", "key is missing"},
    {"negative stiffness", good_scene, "{\"normal\": 40000}", "{\"normal\": -5}", "-5}", "fingers[2].stiffness.normal",
     "a number > 0 (N/m), got -5"},
    {"zero tangential stiffness", good_scene, "\"tangential\": 10000", "\"tangential\": 0", "\"tangential\"",
     "fingers[0].stiffness.tangential", "a number > 0 (N/m)"},
    {"soft without torsional stiffness", good_scene, ", \"torsional\": 1.5", "", "\"stiffness\"",
     "fingers[0].stiffness.torsional", "soft finger"},
    {"soft without torsional friction", good_scene, "      \"torsional_friction\": 0.002,\n", "",
     "    {\n      \"name\": \"left\"", "fingers[0].torsional_friction", "soft finger"},
    {"negative damping", good_scene, "\"normal\": 20,", "\"normal\": -20,", "\"damping\"", "fingers[0].damping.normal",
     "a number >= 0 (N s/m), got -20"},
    {"friction missing", good_scene, "      \"friction\": 0.6,\n", "", "    {\n      \"name\": \"right\"",
     "fingers[1].friction", "key is missing"},
    {"negative friction", good_scene, "\"friction\": 0.6", "\"friction\": -0.6", "-0.6", "fingers[1].friction",
     "a number >= 0, got -0.6"},
    {"friction a list", good_scene, "\"friction\": 0.6", "\"friction\": [0.6, 0.5]", "[0.6", "fingers[1].friction",
     "a number >= 0 or {"},
    {"kinetic friction above static", good_scene, "\"kinetic\": 0.4", "\"kinetic\": 0.6", "\"kinetic\"",
     "fingers[0].friction.kinetic", "0 to the static friction 0.5, got 0.6"},
    {"closing with normal_force", good_scene, "\"closing\": 0.0005,", "\"closing\": 0,\n      \"normal_force\": 5,",
     "normal_force", "fingers[0].normal_force", "at most one of closing and normal_force"},
    {"closing with a slider", good_scene, "\"friction\": 0.6,", "\"friction\": 0.6, \"closing\": 0.001,",
     "\"closing\": 0.001", "fingers[1].closing", "with a slider"},
    {"normal_force with a slider", good_scene, "\"friction\": 0.6,", "\"friction\": 0.6, \"normal_force\": 1,",
     "normal_force", "fingers[1].normal_force", "with a slider"},
    {"negative ramp", good_scene, "\"ramp\": 0.25", "\"ramp\": -1", "\"ramp\"", "fingers[0].ramp",
     "a number >= 0 (s), got -1"},
    {"max_force zero", good_scene, "\"max_force\": 50", "\"max_force\": 0", "\"max_force\"", "fingers[0].max_force",
     "a number > 0 (N)"},
    {"unknown drive", good_scene, "\"slider\"", "\"screw\"", "screw", "fingers[1].drive.type", "fixed, slider or path"},
    {"slider without mass", good_scene, "\"mass\": 0.1, ", "", "\"slider\"", "fingers[1].drive.mass", "key is missing"},
    {"slider's gravity a number", good_scene, "\"gravity\": false", "\"gravity\": 0", "\"slider\"",
     "fingers[1].drive.gravity", "true or false, got 0"},
    {"path without points", good_scene,
     "[\n        {\"time\": 0},\n        {\"time\": 1, \"translation\": [0, 0, 0.01]}\n      ]", "[]", "\"path\"",
     "fingers[2].drive.points", "at least one point"},
    {"path backwards in time", good_scene, "{\"time\": 0},", "{\"time\": 3},", "\"translation\"",
     "fingers[2].drive.points[1].time", "a time not before"},
    {"damage with an unknown key", good_scene, "\"max_slip\"", "\"max_creep\"", "max_creep",
     "fingers[0].damage.max_creep", "a known key (max_force or max_slip)"},
    {"damage negative", good_scene, "\"max_slip\": 0.001", "\"max_slip\": -1", "\"max_slip\"",
     "fingers[0].damage.max_slip", "a number >= 0 (m)"},
    {"two fingers of one name", good_scene, "\"top\"", "\"left\"", "\"left\",\n      \"point\": [0, 0, 0.05]",
     "fingers[2].name", "a name of its own"},

    /* environment, schedule, simulation, solver */
    {"environment without friction", good_scene, ", \"friction\": 0.7", "", "{\"name\": \"table\"",
     "environment[0].friction", "key is missing"},
    {"environment with torsional stiffness", good_scene, "1e5}", "1e5, \"torsional\": 1}", "\"torsional\": 1}",
     "environment[0].stiffness.torsional", "a known key"},
    {"schedule entry without time", good_scene, "{\"time\": 0.5, ", "{", "[0, 0, -9.8]", "schedule[1].time",
     "key is missing"},
    {"schedule backwards in time", good_scene, "\"time\": 1.5", "\"time\": 0.25", "\"time\": 0.25", "schedule[2].time",
     "a time not before the entry in front of it (0.5 s), got 0.25"},
    {"negative time", good_scene, "{\"time\": 0, \"g", "{\"time\": -1, \"g", "\"time\": -1", "schedule[0].time",
     "a number >= 0 (s)"},
    {"sine without frequency", good_scene, "\"frequency\": 10, ", "", "\"amplitude\"", "schedule[2].force.frequency",
     "key is missing"},
    {"sine with an unknown key", good_scene, "\"fade\"", "\"fadein\"", "fadein", "schedule[2].force.fadein",
     "a known key"},
    {"turn about nothing", good_scene, "{\"amplitude\": [1, 0, 0], \"frequency\": 10, \"fade\": 1}",
     "{\"turn\": [1, 0, 0], \"axis\": [0, 0, 0], \"frequency\": 1}", "\"turn\"", "schedule[2].force.axis", "not zero"},
    {"schedule's vector a number", good_scene, "\"gravity\": [0, 0, -9.8]", "\"gravity\": -9.8", "-9.8,",
     "schedule[1].gravity", "a list of 3 numbers (m/s^2), a sine or a turn"},
    {"unknown key in the hand", good_scene, "{\"translation\": [0, 0, 0]}", "{\"shift\": [0, 0, 0]}", "shift",
     "schedule[1].hand.shift", "a known key (translation or rotation)"},
    {"step zero", good_scene, "\"step\": 0.001", "\"step\": 0", "\"step\"", "simulation.step", "a number > 0 (s)"},
    {"step beyond all durations", good_scene, "\"step\": 0.001", "\"step\": 1e308", "\"step\"", "simulation.duration",
     "0, or half a step of 1e+308 s"},
    {"duration of next to nothing", good_scene, "2.5", "1e-320", "1e-320", "simulation.duration", "0, or half a step"},
    {"more steps than fit", good_scene, "2.5", "1e308", "1e308", "simulation.duration", "to 1e+10 steps"},
    {"step alone beyond", good_scene, "{\"step\": 0.001, \"duration\": 2.5}", "{\"step\": 1e-320}", "\"step\"",
     "simulation.step", "at least 1e-10 of it"},
    {"duration negative", good_scene, "2.5", "-2.5", "-2.5", "simulation.duration", "a number >= 0 (s)"},
    {"unknown solver", good_scene, "\"nsnmgk\"", "\"dantzig\"", "dantzig", "solver.name",
     "nsnmgk, nsngrk, newton, lemke or pgs"},
    {"unknown formulation", good_scene, "\"tolerance\": 1e-9", "\"formulation\": \"ncp\"", "ncp", "solver.formulation",
     "coulomb or lcp"},
    {"tolerance zero", good_scene, "1e-9", "0", "\"tolerance\"", "solver.tolerance", "a number > 0"},
    {"iterations not whole", good_scene, "100,", "100.5,", "100.5", "solver.max_iterations",
     "a whole number from 1 to"},
    {"two faces", good_scene, "\"pyramid_faces\": 8", "\"pyramid_faces\": 2", "\"pyramid_faces\"",
     "solver.pyramid_faces", "a whole number from 3 to"},

    /* dimension 2 */
    {"force out of the plane", good_plane, "\"force\": [1, 0, 0]", "\"force\": [1, 0, 2]", "\"force\"", "object.force",
     "a vector in the plane"},
    {"torque in the plane", good_plane, "\"torque\": [0, 0, 1]", "\"torque\": [1, 0, 1]", "\"torque\"", "object.torque",
     "a vector about z"},
    {"gravity out of the plane", good_plane, "[0, -9.81, 0]", "[0, 0, -9.81]", "\"gravity\"", "gravity",
     "a vector in the plane"},
    {"base acceleration out of the plane", good_plane, "\"base_acceleration\": [0, 0, 0]",
     "\"base_acceleration\": [0, 0, 1]", "\"base_acceleration\"", "schedule[0].base_acceleration",
     "a vector in the plane"},
    {"normal out of the plane", good_plane, "\"normal\": [1, 0, 0]", "\"normal\": [1, 0, 0.1]", "\"normal\"",
     "fingers[0].normal", "a vector in the plane"},
    {"point out of the plane", good_plane, "[-0.05, 0, 0]", "[-0.05, 0, 0.01]", "\"point\"", "fingers[0].point",
     "a vector in the plane"},
    {"object turned out of the plane", good_plane, "[1, 0, 0, 0]", "[1, 1, 0, 0]", "\"orientation\"",
     "object.orientation", "a turn about z"},
};

const size_t broken_scene_count = sizeof broken_scenes / sizeof broken_scenes[0];
