/* Private to gpu/: the kernel's text for a device's own compiler (entry.h with everything that it includes). */
#ifndef TMDEMPM_GPU_TEXT_H
#define TMDEMPM_GPU_TEXT_H

extern const unsigned char gpu_kernel_text[]; /* ends with a zero */
extern const unsigned long gpu_kernel_text_bytes;

/* The fatbin; 0 bytes if there was no nvcc when the program was built. */
extern const unsigned char gpu_kernel_fatbin[];
extern const unsigned long gpu_kernel_fatbin_bytes;

#endif
