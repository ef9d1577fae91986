// numpy arrays that look at memory of the libraries, without a copy.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <vector>

#include "omniflight_core/frames.hpp"

namespace omniflight::python {

/// Read-only array of the matrix, rows x columns; `owner` lives as long as the array.
inline pybind11::array view(const Eigen::MatrixXd& m, pybind11::handle owner) {
  const auto item = static_cast<pybind11::ssize_t>(sizeof(double));
  pybind11::array_t<double> out({m.rows(), m.cols()}, {item, item * m.rows()}, m.data(), owner);
  out.attr("flags").attr("writeable") = false;
  return out;
}
inline pybind11::array view(const std::vector<double>& v, pybind11::handle owner) {
  pybind11::array_t<double> out({static_cast<pybind11::ssize_t>(v.size())}, {sizeof(double)}, v.data(),
                                owner);
  out.attr("flags").attr("writeable") = false;
  return out;
}

/// Quaternions are w, x, y, z in Python.
inline Eigen::Vector4d wxyz(const Quat& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Quat quaternion(const Eigen::Vector4d& q) { return Quat(q[0], q[1], q[2], q[3]); }

/// Points as rows.
inline Eigen::MatrixXd rows_of(const std::vector<Vec3>& points) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) out.row(static_cast<Eigen::Index>(i)) = points[i];
  return out;
}

}  // namespace omniflight::python
