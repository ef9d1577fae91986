// Inner products of many long columns, by the BLAS of the machine's instruction set.
#pragma once

#include <Eigen/Core>

namespace omniflight::diagnosis {

/// a^T b for columns of one length [rows x n], [rows x m] -> [n x m], on up to `threads` threads. A library
/// that dispatches at run time does it: most of a search is these products, and a build for every
/// processor of an architecture has a quarter of the lanes of today's.
Eigen::MatrixXf inner_products(Eigen::Ref<const Eigen::MatrixXf> a, Eigen::Ref<const Eigen::MatrixXf> b,
                               int threads = 1);
/// The same in double precision, on the calling thread.
Eigen::MatrixXd inner_products(Eigen::Ref<const Eigen::MatrixXd> a, Eigen::Ref<const Eigen::MatrixXd> b);
/// a^T a.
Eigen::MatrixXd inner_products(Eigen::Ref<const Eigen::MatrixXd> a);

}  // namespace omniflight::diagnosis
