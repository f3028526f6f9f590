// ParaView Catalyst and Python live in a module of their own, tmdempm-catalyst.so beside the viewer, loaded where they
// are asked for: with them the viewer would take ten times as long to start and twice the memory.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "task.h"

// Does a script open views, so that it needs a screen?  In doubt it does.
bool catalyst_script_draws(const std::string &path);

// Catalyst pipelines in Python, working in `folder`; null with what is wrong, or to install, in `error`.
std::unique_ptr<task> catalyst_scripts(const std::vector<std::string> &scripts, const std::string &folder,
									   std::string &error);

// A ParaView that listens at host:port, or will.
std::unique_ptr<task> catalyst_live(const std::string &host, int port, std::string &error);

// Self tests: a script runs; a connection over the loop-back carries data.  False with what to do in `error`.
bool catalyst_test_script(std::string &error);
bool catalyst_test_live(std::string &error);

// What the module exports.
struct catalyst_module {
	task *(*scripts)(const std::vector<std::string> &scripts, const std::string &folder, std::string &error);
	task *(*live)(const std::string &host, int port, std::string &error);
	bool (*test_script)(std::string &error);
	bool (*test_live)(std::string &error);
};
