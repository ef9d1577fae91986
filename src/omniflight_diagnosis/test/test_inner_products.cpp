#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "../src/evidence/inner_products.hpp"

namespace omniflight::diagnosis {
namespace {

TEST(InnerProducts, AreThoseOfTheColumns) {
  const Eigen::MatrixXf a = Eigen::MatrixXf::Random(333, 7), b = Eigen::MatrixXf::Random(333, 1100);
  const Eigen::MatrixXf expected = (a.cast<double>().transpose() * b.cast<double>()).cast<float>();
  for (const int threads : {1, 2})
    EXPECT_LT((inner_products(a, b, threads) - expected).cwiseAbs().maxCoeff(), 1e-3f) << threads;
  EXPECT_LT((inner_products(b.middleCols(5, 3), b, 1) -
             (b.middleCols(5, 3).cast<double>().transpose() * b.cast<double>()).cast<float>())
                .cwiseAbs()
                .maxCoeff(),
            1e-3f)
      << "columns of a larger matrix";
}

TEST(InnerProducts, NothingInNothingOut) {
  EXPECT_EQ(inner_products(Eigen::MatrixXf(4, 0), Eigen::MatrixXf(4, 3)).size(), 0);
  EXPECT_TRUE(inner_products(Eigen::MatrixXf(0, 2), Eigen::MatrixXf(0, 3)).isZero(0));
}

/// A matrix behind which no memory may be read.
class BeforeAWall {
 public:
  BeforeAWall(Eigen::Index rows, Eigen::Index cols) : rows_(rows), cols_(cols) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t bytes = static_cast<std::size_t>(rows * cols) * sizeof(float);
    const std::size_t before = (bytes + page - 1) / page * page;
    size_ = before + page;
    memory_ =
        static_cast<char*>(mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    EXPECT_NE(memory_, MAP_FAILED);
    EXPECT_EQ(mprotect(memory_ + before, page, PROT_NONE), 0);
    data_ = reinterpret_cast<float*>(memory_ + before - bytes);
    matrix().setRandom();
  }
  ~BeforeAWall() { munmap(memory_, size_); }
  BeforeAWall(const BeforeAWall&) = delete;
  BeforeAWall& operator=(const BeforeAWall&) = delete;
  Eigen::Map<Eigen::MatrixXf> matrix() { return {data_, rows_, cols_}; }

 private:
  Eigen::Index rows_, cols_;
  std::size_t size_ = 0;
  char* memory_ = nullptr;
  float* data_ = nullptr;
};

TEST(InnerProducts, ReadNothingBehindTheirOperands) {
  for (const Eigen::Index rows : {1, 7, 23, 1555})
    for (Eigen::Index m = 1; m < 14; ++m)
      for (const Eigen::Index n : {1, 3, 17, 64}) {
        BeforeAWall a(rows, m), b(rows, n);
        const Eigen::MatrixXf expected = a.matrix().transpose() * b.matrix();
        ASSERT_TRUE(inner_products(a.matrix(), b.matrix(), 1).isApprox(expected, 1e-4f))
            << rows << " " << m << " " << n;
      }
}

}  // namespace
}  // namespace omniflight::diagnosis
