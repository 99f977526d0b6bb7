#ifndef PINCH_COMPLETION_H
#define PINCH_COMPLETION_H

#include <stdio.h>

/* Each writes a completion script for one shell, made from command_table and the table of options. */
void completion_bash(FILE *stream);
void completion_zsh(FILE *stream);
void completion_fish(FILE *stream);

#endif
