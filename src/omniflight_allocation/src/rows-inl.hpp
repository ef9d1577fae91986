// Rows of 8 or 16 numbers in as many vectors as the instruction set needs. Included once for every
// instruction set.
#if defined(OMNIFLIGHT_ALLOCATION_ROWS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef OMNIFLIGHT_ALLOCATION_ROWS_INL
#undef OMNIFLIGHT_ALLOCATION_ROWS_INL
#else
#define OMNIFLIGHT_ALLOCATION_ROWS_INL
#endif

#include <cstdint>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace omniflight::allocation::qp_kernel {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <int P>
struct Rows {
  using D = hn::CappedTag<double, 8>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;
  static constexpr D d{};
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D{}));
  static constexpr int kParts = P / kLanes;

  struct Row {
    V part[kParts];
  };
  static HWY_INLINE Row load(const double* p) {
    Row row;
    for (int k = 0; k < kParts; ++k) row.part[k] = hn::Load(d, p + k * kLanes);
    return row;
  }
  static HWY_INLINE void store(const Row& row, double* p) {
    for (int k = 0; k < kParts; ++k) hn::Store(row.part[k], d, p + k * kLanes);
  }
  template <class F>
  static HWY_INLINE Row each(F f) {
    Row row;
    for (int k = 0; k < kParts; ++k) row.part[k] = f(k);
    return row;
  }
  static HWY_INLINE M mask(std::uint32_t bits, int k) {
    const std::uint64_t part = bits >> (k * kLanes);
    return hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&part));
  }
  template <class F>
  static HWY_INLINE std::uint32_t bits(F f) {
    std::uint32_t all = 0;
    for (int k = 0; k < kParts; ++k) {
      std::uint64_t part = 0;
      hn::StoreMaskBits(d, f(k), reinterpret_cast<std::uint8_t*>(&part));
      all |= static_cast<std::uint32_t>(part) << (k * kLanes);
    }
    return all;
  }
  static HWY_INLINE double largest(const Row& row) {
    V most = row.part[0];
    for (int k = 1; k < kParts; ++k) most = hn::Max(most, row.part[k]);
    return hn::GetLane(hn::MaxOfLanes(d, most));
  }
  static HWY_INLINE V clip(V x, V low, V high) { return hn::Min(hn::Max(x, low), high); }
};

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::allocation::qp_kernel
HWY_AFTER_NAMESPACE();
#endif
