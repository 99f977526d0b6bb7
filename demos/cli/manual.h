#ifndef PINCH_MANUAL_H
#define PINCH_MANUAL_H

#include "command.h"

/* Writes the manual pages and the shell completions of all subcommands below `folder`, which is made where it is not
 * there, as `share` has them: man/man1, bash-completion/completions, zsh/site-functions, fish/vendor_completions.d. On
 * failure the reason is on standard error. */
command_status manual_write(const char *folder);

/* completion.c: each writes a completion script for one shell, made from the same tables. */
void completion_bash(FILE *stream);
void completion_zsh(FILE *stream);
void completion_fish(FILE *stream);

#endif
