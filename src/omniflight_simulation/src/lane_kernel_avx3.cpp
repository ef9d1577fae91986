// The lanes with AVX-512 and with SSE4: half of the work of compiling them.
#define OMNIFLIGHT_LANE_TARGETS HWY_AVX3 | HWY_SSE4
#include "lane_kernel-inl.hpp"
