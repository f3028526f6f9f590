// Where things stand on a page: window, colour bar, heading, length scale; common to all pictures.
#pragma once

#include "page.h"
#include "scale.h"

struct layout {
	box window; // pixels
	box group;  // window and colour bar together
	bool lying; // the bar stands beside the window, or lies under it
};

// The largest window for `view` (m) with a bar beside or under it, and `foot` page units left free below.
// Makes the page look there.
layout layout_make(page &page, const box &view, const colour_scale &scale, double foot);

// The colour bar where the layout has its place.
void layout_bar(page &page, const layout &where, const colour_scale &scale);

// "t = 0.250 s", "t = 3.2 ms".
std::string layout_time(double time);

// Title on the left, the clock's words on the right, above the group.
void layout_heading(page &page, const layout &where, const std::string &title, const std::string &clock);

// A bar of a round length in metres, and its words.
struct length_scale {
	double pixels;
	std::string text;
	double width; // bar and words, pixels
};
length_scale length_scale_make(const page &page, const layout &where);

// Draws it from (x, y) on, y being its middle.
void length_scale_draw(page &page, const length_scale &scale, double x, double y);

// A thin frame around the window.
void layout_frame(page &page, const layout &where);

// A line of text `below` page units under the group.
void layout_note(page &page, const layout &where, const std::string &text, double below);

// Cuts a text that is wider than `width` pixels.
std::string layout_fit(const page &page, std::string text, double size, double width);
