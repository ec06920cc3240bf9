// Pose of a paraboloid from nine touches by Ceres' Levenberg-Marquardt, on the exact distance.
//
// Usage: pose DIR. Reads poses.bin (see problems.py); one JSON line a size of start: starts, those that
// ended at Σ (e/σ)² < 40, and the median time of a solution in µs. One thread, default options but for
// the tolerances.
#include <ceres/ceres.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

constexpr double kRadius = 480.0, kTip = 3.0, kSigma = 1e-3, kFound = 40.0;
constexpr int kTouches = 9, kRow = 1 + 3 * kTouches + 5;

struct Distance {
  const double* q;
  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    using std::cos, std::sin, std::sqrt;
    const T ca = cos(pose[3]), sa = sin(pose[3]), cb = cos(pose[4]), sb = sin(pose[4]);
    const T v[3] = {q[0] - pose[0], q[1] - pose[1], q[2] - pose[2]};
    // (Ry Rx)ᵀ v; γ is held at zero.
    const T x = cb * v[0] - sb * v[2];
    const T y = sb * sa * v[0] + ca * v[1] + cb * sa * v[2];
    const T z = sb * ca * v[0] - sa * v[1] + cb * ca * v[2];
    const T rho = sqrt(x * x + y * y + T(1e-300));
    // Foot of the perpendicular: Newton on (r − ρ) + (r²/2R − z) r/R.
    T r = rho;
    for (int i = 0; i < 8; ++i) {
      const T gap = r * r / (2.0 * kRadius) - z;
      r -= ((r - rho) + gap * r / kRadius) / (1.0 + r * r / (kRadius * kRadius) + gap / kRadius);
    }
    const T slope = r / kRadius;
    residual[0] = (((z - r * slope / 2.0) - slope * (rho - r)) / sqrt(1.0 + slope * slope) - kTip) / kSigma;
    return true;
  }
};

int main(int, char** argv) {
  std::ifstream file(std::string(argv[1]) + "/poses.bin", std::ios::binary);
  std::vector<double> row(kRow);
  double size = -1.0;
  int found = 0, starts = 0;
  std::vector<double> times;
  auto print = [&] {
    if (starts == 0) return;
    std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
    std::printf("{\"size\":%g,\"found\":%d,\"starts\":%d,\"median_us\":%.2f}\n", size, found, starts,
                times[times.size() / 2]);
  };
  while (file.read(reinterpret_cast<char*>(row.data()), kRow * sizeof(double))) {
    if (row[0] != size) {
      print();
      size = row[0], found = 0, starts = 0;
      times.clear();
    }
    double pose[5];
    std::copy(row.end() - 5, row.end(), pose);
    const auto begin = std::chrono::steady_clock::now();
    ceres::Problem problem;
    for (int i = 0; i < kTouches; ++i) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Distance, 1, 5>(new Distance{&row[1 + 3 * i]}), nullptr, pose);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-14;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
    times.push_back(time.count());
    ++starts;
    found += summary.IsSolutionUsable() && 2.0 * summary.final_cost < kFound;
  }
  print();
}
