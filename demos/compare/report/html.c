#include "report.h"

#include "compare/access.h"

#include <stdlib.h>

void html_text(const char *text, FILE *stream)
{
    for (; *text; text++) {
        switch (*text) {
        case '&':
            fputs("&amp;", stream);
            break;
        case '<':
            fputs("&lt;", stream);
            break;
        case '>':
            fputs("&gt;", stream);
            break;
        case '"':
            fputs("&quot;", stream);
            break;
        case '\'':
            fputs("&#39;", stream);
            break;
        default:
            if ((unsigned char)*text >= ' ' && *text != 127) fputc(*text, stream);
        }
    }
}

void html_number(double value, FILE *stream)
{
    char text[32];
    if (!isfinite(value)) {
        fputs("&ndash;", stream);
        return;
    }
    snprintf(text, sizeof text, "%.3g", value);
    char *power = strchr(text, 'e');
    if (power) *power = '\0';
    if (text[0] == '-')
        fprintf(stream, "&minus;%s", text + 1);
    else
        fputs(text, stream);
    if (power) {
        int exponent = atoi(power + 1);
        fprintf(stream, "&#8239;&times;&#8239;10<sup>%s%d</sup>", exponent < 0 ? "&minus;" : "", abs(exponent));
    }
}

const char *html_run_class(size_t run)
{
    static const char *const classes[] = {"s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9"};
    return classes[run % 10];
}

/* ---- Judgements. ---- */

static const double EXACT = 1e-9, CLOSE = 0.01; /* of the force scale */
static const double AT_REST = 1e-8;             /* m/s: an object that creeps less in Pinch's run is held still */

verdict verdict_of(const json_t *run)
{
    double error = access_metric(run, METRIC_FORCE_ERROR_MAX);
    if (access_metric(run, METRIC_DROPPED) > 0) return VERDICT_DROPPED;
    if (isnan(error)) return VERDICT_UNKNOWN;
    return error <= EXACT ? VERDICT_EXACT : error <= CLOSE ? VERDICT_CLOSE : VERDICT_OFF;
}

const char *verdict_word(verdict v)
{
    static const char *const words[] = {"exact", "close", "off", "dropped", "unknown"};
    return words[v];
}

static double drop_time(const json_t *run)
{
    const json_t *events = json_object_get(run, "events");
    for (size_t i = 0; i < json_array_size(events); i++)
        if (strcmp(access_text(json_array_get(events, i), "type"), "dropped") == 0)
            return access_number(json_array_get(events, i), "time");
    return NAN;
}

/* A length in the unit that people use for it. */
static void write_length(double metres, const char *per, FILE *stream)
{
    const double size = fabs(metres);
    html_number(size < 1e-3 ? 1e6 * metres : size < 1 ? 1e3 * metres : metres, stream);
    fprintf(stream, "&nbsp;%s%s", size < 1e-3 ? "&micro;m" : size < 1 ? "mm" : "m", per);
}

static void write_forces(const json_t *run, FILE *stream)
{
    double worst = access_metric(run, METRIC_FORCE_ERROR_MAX), usual = access_metric(run, METRIC_FORCE_ERROR_MEDIAN);
    if (isnan(worst)) {
        fputs("no forces were compared", stream);
    } else if (worst <= EXACT) {
        fputs("forces are exact (to ", stream);
        html_number(worst, stream);
        fputs(" of the largest)", stream);
    } else {
        fputs("forces are off by up to ", stream);
        html_number(100 * worst, stream);
        fputs("&nbsp;%, usually ", stream);
        html_number(100 * usual, stream);
        fputs("&nbsp;%", stream);
    }
}

static void write_motion(const json_t *of_scene, const json_t *run, FILE *stream)
{
    const json_t *pinch = access_run(of_scene, "pinch");
    double dropped = drop_time(run), creep = access_metric(run, METRIC_CREEP);
    if (access_metric(run, METRIC_DROPPED) > 0) {
        fputs("; drops the object after ", stream);
        html_number(dropped, stream);
        fputs("&nbsp;s", stream);
        return;
    }
    if (access_metric(pinch, METRIC_CREEP) <= AT_REST) {
        fputs(creep <= AT_REST ? "; the object stays where it is (" : "; the object creeps (", stream);
        write_length(creep, "/s", stream);
        fputc(')', stream);
    }
    double apart = access_metric(run, METRIC_DIVERGENCE_END);
    if (isnan(apart)) return;
    fputs("; ends ", stream);
    write_length(apart, "", stream);
    fputs(" from Pinch&rsquo;s run", stream);
}

void verdict_write(const json_t *of_scene, const json_t *run, FILE *stream)
{
    double cost = access_metric(run, METRIC_COST) / access_metric(access_run(of_scene, "pinch"), METRIC_COST);
    write_forces(run, stream);
    write_motion(of_scene, run, stream);
    if (access_metric(run, METRIC_VERIFIED) == 0) fputs("; <strong>not every step is verified</strong>", stream);
    if (strcmp(access_text(run, "run"), "pinch") != 0) {
        fputs("; a step costs ", stream);
        html_number(cost, stream);
        fputs(" times Pinch&rsquo;s", stream);
    }
    fputc('.', stream);
}
