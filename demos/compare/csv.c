#include "csv.h"

#include "access.h"
#include "common/json_output.h"

/* Quoted as RFC 4180 has it where the text needs it. */
static void put_text(const char *text, FILE *stream)
{
    if (!text[strcspn(text, ",\"\r\n")]) {
        fputs(text, stream);
        return;
    }
    fputc('"', stream);
    for (; *text; text++) {
        if (*text == '"') fputc('"', stream);
        fputc(*text, stream);
    }
    fputc('"', stream);
}

void csv_write(const json_t *scenes, FILE *stream)
{
    fputs("scene,run,metric,value,unit\n", stream);
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const json_t *scene = json_array_get(scenes, i), *runs = json_object_get(scene, "runs");
        for (size_t k = 0; k < json_array_size(runs); k++)
            for (int m = 0; m < METRIC_COUNT; m++) {
                const json_t *run = json_array_get(runs, k);
                double value = access_metric(run, (metric)m);
                char text[32] = "";
                if (!isnan(value)) json_number_text(value, text);
                put_text(access_text(scene, "scene"), stream);
                fprintf(stream, ",%s,%s,%s,%s\n", access_text(run, "run"), metric_about((metric)m)->key, text,
                        metric_about((metric)m)->unit);
            }
    }
}
