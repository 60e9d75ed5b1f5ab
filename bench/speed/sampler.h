/* What a shared library must have so that `python -m bench.speed.frames --against LIBRARY` times it beside the kernels.

   It writes the upper body of one clip on the lower body of another, as your engine does. The clips are those of a bank
   (docs/bank.md): read them from its tables, or export them with `motionsplice splice` and convert them beforehand.
   cpp_twin.cpp in this folder is an example. Compile yours with `-O3 -march=native -shared -fPIC`. */
#pragma once
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What one character plays. Clips are numbers, in the order of the manifest. */
typedef struct {
    int32_t locomotion; /* the clip that gives the root and the lower body */
    int32_t action;     /* the clip that gives the upper body */
    double time;        /* seconds into the locomotion */
    double start;       /* seconds of the action from which on it begins: for a library that aligns it by itself */
    double action_time; /* seconds into the action: for a library that only samples. It may lie in the clip's seam */
} sampler_request;

/* Opens the bank in a folder. Returns what the other functions get, or null. */
void* sampler_open(const char* bank);

/* Writes local rotations [count, J, 4], xyzw, of all joints, and root positions [count, 3], metres. Returns 0, or
   another number for a failure. It is called by one thread, with the same addresses again and again. */
int sampler_evaluate(void* sampler, const sampler_request* requests, int32_t count, float* rotations,
                     float* root_positions);

void sampler_close(void* sampler);

#ifdef __cplusplus
}
#endif
