#include <pinch/status.h>

const char *pinch_status_text(pinch_status status)
{
    switch (status) {
    case PINCH_OK:
        return "ok";
    case PINCH_INVALID_ARGUMENT:
        return "invalid argument";
    case PINCH_OUT_OF_MEMORY:
        return "out of memory";
    case PINCH_UNSUPPORTED:
        return "unsupported";
    case PINCH_SYSTEM_FAILURE:
        return "system failure";
    }
    return "unknown status";
}

const char *pinch_solve_status_text(pinch_solve_status status)
{
    switch (status) {
    case PINCH_SOLVE_CONVERGED:
        return "converged";
    case PINCH_SOLVE_MAX_ITERATIONS:
        return "max_iterations";
    case PINCH_SOLVE_DIVERGED:
        return "diverged";
    case PINCH_SOLVE_INFEASIBLE:
        return "infeasible";
    case PINCH_SOLVE_UNSTABLE:
        return "unstable";
    case PINCH_SOLVE_RAY:
        return "ray";
    case PINCH_SOLVE_UNVERIFIED:
        return "unverified";
    }
    return "unknown";
}
