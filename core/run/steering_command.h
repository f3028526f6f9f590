/* The language of steering: one command, as text and as data.  steering.h says what each does. */
#ifndef TMDEMPM_RUN_STEERING_COMMAND_H
#define TMDEMPM_RUN_STEERING_COMMAND_H

#include <stdbool.h>

#include "run/rules.h"

enum steering_verb { STEER_PAUSE, STEER_STEP, STEER_CHECKPOINT, STEER_STOP, STEER_INSPECT, STEER_IMAGE };
enum steering_pause { STEER_GO_ON, STEER_PAUSE_ON, STEER_PAUSE_HOLD };
enum steering_target { STEER_NOTHING, STEER_POINT, STEER_AT, STEER_RULE };

struct steering_command {
	enum steering_verb verb;
	enum steering_pause pause;
	long long steps;       /* STEER_STEP */
	char name[SCENE_NAME]; /* of the RVE or the picture */
	enum steering_target target;
	int point;    /* its id */
	double at[2]; /* m */
	const struct rve_rule *rule;
	double every; /* s; 0 = never */
};

enum { STEERING_TEXT = 256 }; /* bytes of a command, with its end */

/* Blanks around the command and its `=` do not matter.  STATUS_INPUT: what is wrong and what was expected. */
int steering_parse(struct steering_command *command, const char *text);

/* The command as it is written; parsing it gives the same bits. */
void steering_print(const struct steering_command *command, char text[STEERING_TEXT]);

/* Is it over when it is done (pause, step, checkpoint, stop), or does it hold on (what is inspected, intervals)? */
bool steering_lasts(const struct steering_command *command);

/* Lines of `tmdempm steer --help`: command and what it does. */
extern const char steering_help[];

#endif
