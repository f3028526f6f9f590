#include <stdio.h>

#include "version.h"

int main(void)
{
	printf("tmdempm %s\n", TMDEMPM_VERSION);
	return 0;
}
