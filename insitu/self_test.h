// tmdempm-viewer --self-test: does a part of it work on this machine?  For `tmdempm doctor`.
#pragma once

// `what`: display, gl, catalyst or live.  Prints one line, what works or what to do.  0: works; 1: does not; 2: no such
// test.
int self_test(const char *what);
