// What tmdempm-catalyst.so can do (insitu/catalyst_module.h).
#pragma once

#include "catalyst_module.h"

task *scripts_create(const std::vector<std::string> &scripts, const std::string &folder, std::string &error);
task *live_create(const std::string &host, int port, std::string &error);
bool scripts_test(std::string &error);
bool live_test(std::string &error);
