#include "pose_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace omniflight::planning {

double pose_distance(const Pose& a, const Pose& b) {
  const double cosine = std::min(1.0, std::abs(a.q_WB.dot(b.q_WB)));
  return (a.p_WB - b.p_WB).norm() + std::sqrt(2.0 * (1.0 - cosine));
}

PoseIndex::Bucket::Bucket() {
  for (auto& row : rows) row.fill(0.0f);
  rows[0].fill(std::numeric_limits<float>::infinity());
  numbers.fill(0);
}

PoseIndex::Row PoseIndex::row_of(const Pose& pose) {
  const double sign = pose.q_WB.w() < 0.0 ? -1.0 : 1.0;
  const auto narrow = [](double x) { return static_cast<float>(x); };
  return {narrow(pose.p_WB.x()),        narrow(pose.p_WB.y()),        narrow(pose.p_WB.z()),
          narrow(sign * pose.q_WB.x()), narrow(sign * pose.q_WB.y()), narrow(sign * pose.q_WB.z()),
          narrow(sign * pose.q_WB.w())};
}

void PoseIndex::put(std::uint32_t bucket, const Row& row, std::uint32_t number) {
  while (buckets_[bucket].count == kBucket) {
    if (buckets_[bucket].next == kNone) {
      buckets_[bucket].next = static_cast<std::uint32_t>(buckets_.size());
      buckets_.emplace_back();
    }
    bucket = buckets_[bucket].next;
  }
  Bucket& into = buckets_[bucket];
  for (std::size_t k = 0; k < row.size(); ++k) into.rows[k][into.count] = row[k];
  into.numbers[into.count++] = number;
}

void PoseIndex::add(const Pose& pose) {
  const Row row = row_of(pose);
  const auto leaf_of = [&] {
    std::uint32_t at = 0;
    while (nodes_[at].axis >= 0)
      at = row[static_cast<std::size_t>(nodes_[at].axis)] < nodes_[at].at ? nodes_[at].low : nodes_[at].high;
    return at;
  };
  std::uint32_t leaf = leaf_of();
  if (buckets_[nodes_[leaf].low].count == kBucket && buckets_[nodes_[leaf].low].next == kNone) {
    split(leaf);
    leaf = leaf_of();
  }
  put(nodes_[leaf].low, row, static_cast<std::uint32_t>(size_++));
}

void PoseIndex::split(std::uint32_t node) {
  const std::uint32_t first = nodes_[node].low;
  std::size_t axis = 0;
  float spread = 0.0f;
  for (std::size_t k = 0; k < 7; ++k) {
    const auto [low, high] =
        std::minmax_element(buckets_[first].rows[k].begin(), buckets_[first].rows[k].end());
    if (*high - *low > spread) spread = *high - *low, axis = k;
  }
  if (!(spread > 0.0f)) return;  // all alike
  auto values = buckets_[first].rows[axis];
  std::sort(values.begin(), values.end());
  // a value that parts them, the nearest to the middle
  float at = values[kBucket / 2];
  if (at == values.front()) at = *std::upper_bound(values.begin(), values.end(), at);
  const Bucket all = buckets_[first];
  buckets_[first] = Bucket{};
  const auto second = static_cast<std::uint32_t>(buckets_.size());
  buckets_.emplace_back();
  const auto low = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({-1, 0.0f, first, 0});
  nodes_.push_back({-1, 0.0f, second, 0});
  for (std::size_t i = 0; i < kBucket; ++i) {
    Row row;
    for (std::size_t k = 0; k < 7; ++k) row[k] = all.rows[k][i];
    put(row[axis] < at ? first : second, row, all.numbers[i]);
  }
  nodes_[node] = {static_cast<std::int32_t>(axis), at, low, low + 1};
}

void PoseIndex::search(std::uint32_t number, const Row& at, Row& beyond, Best& best) const {
  const Node& node = nodes_[number];
  if (node.axis < 0) {
    for (std::uint32_t b = node.low; b != kNone; b = buckets_[b].next) {
      const Bucket& bucket = buckets_[b];
      const auto& r = bucket.rows;
      alignas(64) std::array<float, kBucket> distance;
      for (std::size_t i = 0; i < kBucket; ++i) {
        const float x = r[0][i] - at[0], y = r[1][i] - at[1], z = r[2][i] - at[2];
        const float a = r[3][i] - at[3], c = r[4][i] - at[4], d = r[5][i] - at[5], e = r[6][i] - at[6];
        distance[i] = std::sqrt(x * x + y * y + z * z) + std::sqrt(a * a + c * c + d * d + e * e);
      }
      for (std::size_t i = 0; i < bucket.count; ++i)
        if (distance[i] < best.distance) best = {distance[i], bucket.numbers[i]};
    }
    return;
  }
  const auto axis = static_cast<std::size_t>(node.axis);
  const bool is_low = at[axis] < node.at;
  search(is_low ? node.low : node.high, at, beyond, best);
  const float before = beyond[axis];
  beyond[axis] = std::abs(at[axis] - node.at);
  const float way = beyond[0] * beyond[0] + beyond[1] * beyond[1] + beyond[2] * beyond[2];
  const float chord =
      beyond[3] * beyond[3] + beyond[4] * beyond[4] + beyond[5] * beyond[5] + beyond[6] * beyond[6];
  if ((std::sqrt(way) + std::sqrt(chord)) * static_cast<float>(1.0 + kSlack) < best.distance)
    search(is_low ? node.high : node.low, at, beyond, best);
  beyond[axis] = before;
}

std::size_t PoseIndex::near(const Pose& pose) const {
  Best best{std::numeric_limits<float>::infinity(), 0};
  Row at = row_of(pose), beyond{};
  search(0, at, beyond, best);
  // an attitude has two quaternions, and the other one lies outside of the tree
  for (std::size_t k = 3; k < at.size(); ++k) at[k] = -at[k];
  beyond = {};
  beyond[6] = -at[6];
  if (beyond[6] * static_cast<float>(1.0 + kSlack) < best.distance) search(0, at, beyond, best);
  return best.number;
}

}  // namespace omniflight::planning
