// The lanes with AVX2 and with every instruction set that lane_kernel_avx3.cpp has not, other processors'
// included.
#define OMNIFLIGHT_LANE_TARGETS ~(HWY_AVX3 | HWY_SSE4)
#include "lane_kernel-inl.hpp"
