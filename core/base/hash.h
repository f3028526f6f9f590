/* FNV-1a, 64 bits: tells contents apart, protects against accidents only. */
#ifndef TMDEMPM_BASE_HASH_H
#define TMDEMPM_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define HASH_START UINT64_C(14695981039346656037)

/* The hash of what was hashed before (HASH_START: nothing) and `size` more bytes. */
uint64_t hash_bytes(uint64_t hash, const void *data, size_t size);

/* The same of a text with its end, so that two texts are not one long one. */
uint64_t hash_text(uint64_t hash, const char *text);

#endif
