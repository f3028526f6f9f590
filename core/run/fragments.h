/* Pieces and cracks of what has broken: from points, their places at birth and now, and their damage.
 *
 * A piece is a set of unbroken points (damage < 0.9) of one body that are neighbours of each other on the body's lattice and
 * have stayed so.  A crack begins at a place of the body at birth, and goes on through broken points that touch. */
#ifndef TMDEMPM_RUN_FRAGMENTS_H
#define TMDEMPM_RUN_FRAGMENTS_H

#include <stddef.h>

/* Points in any order; arrays of n. */
struct fragment_points {
	int n;
	const double (*X)[2];  /* m, at birth */
	const double (*x)[2];  /* m, now */
	const double *damage;  /* NAN counts as whole */
	const double *spacing; /* m, of its lattice */
	const double *mass;    /* kg */
	const int *body;
};

struct fragment {
	int points, body;
	double mass;        /* kg */
	double area;        /* m2, as it was at birth */
	double centre[2];   /* m, now */
	double diameter;    /* m, of the disc of equal area */
	double roundness;   /* area over that of the disc as wide as the piece is long; 1 = a disc (of a square 0.95) */
};

struct fragments {
	int n, *label;         /* of each point, -1 = broken; pieces are numbered by size, the largest first */
	int count;
	struct fragment *list; /* [count] */
	double broken;         /* m2, area of broken points */
};

/* What they are on average: by number, where the smallest count most, and by area, where the largest do. */
struct fragment_summary {
	int count;
	double diameter_mean, diameter_deviation; /* m, by number */
	double area_mean, area_deviation;         /* m, of the diameter by area */
	double roundness_mean;
	double largest, broken;                   /* m2 */
};

struct crack {
	double tip[2];   /* m, now: the broken point of the crack that was farthest from its beginning */
	double length;   /* m, from there to it at birth; 0 = none yet */
	double angle;    /* rad, of that way from the x axis; NAN = none yet */
};

/* Free with fragments_free().  STATUS_RESOURCE. */
int fragments_find(struct fragments *fragments, const struct fragment_points *points);
void fragments_free(struct fragments *fragments);
struct fragment_summary fragments_summary(const struct fragments *fragments);

/* The crack that begins within `reach` (m) of a place at birth. */
int fragments_crack(struct crack *crack, const struct fragment_points *points, const double at[2], double reach);

/* The middle of what is broken, as segments: centres of the broken points in boxes of the size of two of them, joined by the
 * shortest tree between boxes that touch.  *nodes (m, now; *n_nodes) and pairs of them (*segments, *n_segments) are the
 * caller's to free. */
int fragments_lines(const struct fragment_points *points, double (**nodes)[2], int *n_nodes, int (**segments)[2],
					int *n_segments);

#endif
