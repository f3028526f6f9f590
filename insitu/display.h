// The X server that these VTK builds need even off screen: the user's, or an Xvfb of our own.
#pragma once

#include <string>

class display
{
  public:
	~display(); // ends our Xvfb

	// Makes $DISPLAY usable.  False with what to install in `error`; `log` says what was started, if anything.
	bool open(std::string &log, std::string &error);

  private:
	int xvfb = 0; // process id
};
