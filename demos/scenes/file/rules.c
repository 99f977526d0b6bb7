/* Rules of a hand: values by names or globs of what they are for. Of those that match, the most specific wins. */
#include "reader.h"

#include <fnmatch.h>
#include <string.h>

/* An exact name is the most specific; of globs the one with the most characters that stand for themselves. */
static size_t specificity(const char *pattern)
{
    size_t plain = 0;
    bool glob = false;
    for (const char *c = pattern; *c; c++) {
        bool special = *c == '*' || *c == '?' || *c == '[';
        glob = glob || special;
        plain += !special;
    }
    return glob ? plain : (size_t)1 << 20;
}

static bool is_exact(const char *pattern)
{
    return strpbrk(pattern, "*?[") == NULL;
}

static bool matches(const scene_rules *rules, const char *pattern, size_t index)
{
    const char *name = rules->name(rules->things, index);
    const char *other = rules->other_name ? rules->other_name(rules->things, index) : NULL;
    if (!is_exact(pattern) && rules->by_name_only && rules->by_name_only(rules->things, index)) return false;
    return fnmatch(pattern, name, 0) == 0 || strcmp(pattern, name) == 0 ||
           (other && (fnmatch(pattern, other, 0) == 0 || strcmp(pattern, other) == 0));
}

/* "a, b (other name of b), c, ..." as far as there is room */
static void list_things(const scene_rules *rules, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < rules->count; i++) {
        const char *name = rules->name(rules->things, i);
        const char *other = rules->other_name ? rules->other_name(rules->things, i) : NULL;
        if (!other || strcmp(other, name) == 0) other = "";
        const char *const brackets[] = {*other ? " (" : "", *other ? ")" : ""};
        if (used + strlen(name) + strlen(other) + 11 > size) {
            strcpy(text + used, ", ...");
            return;
        }
        used += (size_t)snprintf(text + used, size - used, "%s%s%s%s%s", i ? ", " : "", name, brackets[0], other,
                                 brackets[1]);
    }
}

bool scene_rules_check(const scene_node *node, const scene_rules *rules)
{
    const char *key;
    json_t *value;
    json_object_foreach(node->value, key, value)
    {
        bool found = false;
        for (size_t i = 0; i < rules->count && !found; i++) found = matches(rules, key, i);
        if (found) continue;
        char list[900];
        scene_node member = scene_member(node, key);
        list_things(rules, list, sizeof list);
        return scene_refuse_plainly(&member, "the name of a %s, or a glob that matches one; there are %s", rules->what,
                                    *list ? list : "none");
    }
    return true;
}

const char *scene_rule_after(const scene_node *node, const scene_rules *rules, size_t index, const char *after)
{
    const char *best = NULL, *key;
    json_t *value;
    size_t last = after ? specificity(after) : 0, best_specificity = 0;
    bool past = !after; /* is the key behind `after` in the file? */
    json_object_foreach(node->value, key, value)
    {
        size_t s = specificity(key);
        bool follows = !after || s > last || (s == last && past);
        if (after && strcmp(key, after) == 0)
            past = true;
        else if (follows && matches(rules, key, index) && (!best || s < best_specificity)) {
            best = key;
            best_specificity = s;
        }
    }
    return best;
}
