// small_gicp with a point-to-plane factor that is one:
// small_gicp_plane DISTANCE_MM STEP_MM FOLDER THREADS RUNS
//
// The factor that comes with small_gicp 1.0.1 multiplies normal and offset entry by entry, which
// penalises all of an offset wherever the normal is oblique. Here the residual is their dot product;
// tree, search, reduction and solver are the library's. Pairs further apart than the distance do not
// count. Stops at a step of STEP_MM, a hundredth of it in rad, or after 100 iterations. One JSON line a run, as python_peers.py prints them.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <small_gicp/ann/kdtree_omp.hpp>
#include <small_gicp/points/point_cloud.hpp>
#include <small_gicp/registration/reduction_omp.hpp>
#include <small_gicp/registration/registration.hpp>
#include <small_gicp/util/lie.hpp>

namespace {

struct PlaneFactor {
  struct Setting {};

  PlaneFactor(const Setting& = Setting()) {}

  template <typename Target, typename Source, typename Tree, typename Rejector>
  bool linearize(const Target& target, const Source& source, const Tree& tree,
                 const Eigen::Isometry3d& T, size_t index, const Rejector& rejector,
                 Eigen::Matrix<double, 6, 6>* H, Eigen::Matrix<double, 6, 1>* b, double* e) {
    source_index = index;
    target_index = kNone;
    const Eigen::Vector4d& point = small_gicp::traits::point(source, index);
    const Eigen::Vector4d moved = T * point;
    size_t nearest;
    double squared;
    if (!small_gicp::traits::nearest_neighbor_search(tree, moved, &nearest, &squared) ||
        rejector(target, source, T, nearest, index, squared)) {
      return false;
    }
    target_index = nearest;
    const Eigen::Vector4d& normal = small_gicp::traits::normal(target, nearest);
    const double residual = normal.dot(small_gicp::traits::point(target, nearest) - moved);
    // Steps are to the right of T: rotation, then translation.
    const Eigen::Vector3d turned = T.linear().transpose() * normal.head<3>();
    Eigen::Matrix<double, 6, 1> J;
    J.head<3>() = -point.head<3>().cross(turned);
    J.tail<3>() = -turned;
    *H = J * J.transpose();
    *b = J * residual;
    *e = 0.5 * residual * residual;
    return true;
  }

  template <typename Target, typename Source>
  double error(const Target& target, const Source& source, const Eigen::Isometry3d& T) const {
    if (target_index == kNone) return 0.0;
    const Eigen::Vector4d moved = T * small_gicp::traits::point(source, source_index);
    const double residual = small_gicp::traits::normal(target, target_index)
                                .dot(small_gicp::traits::point(target, target_index) - moved);
    return 0.5 * residual * residual;
  }

  bool inlier() const { return target_index != kNone; }

  static constexpr size_t kNone = std::numeric_limits<size_t>::max();
  size_t target_index = kNone;
  size_t source_index = kNone;
};

std::vector<double> Read(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  std::vector<double> numbers(static_cast<size_t>(in.tellg()) / sizeof(double));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(numbers.data()), numbers.size() * sizeof(double));
  return numbers;
}

std::vector<Eigen::Vector4d> Homogeneous(const std::vector<double>& numbers, double last) {
  std::vector<Eigen::Vector4d> points;
  for (size_t i = 0; i + 2 < numbers.size(); i += 3) {
    points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2], last);
  }
  return points;
}

double Since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) return 1;
  const double distance_mm = std::atof(argv[1]), step_mm = std::atof(argv[2]);
  const std::string folder = argv[3];
  const int threads = std::atoi(argv[4]), runs = std::atoi(argv[5]);
  auto target = std::make_shared<small_gicp::PointCloud>();
  auto source = std::make_shared<small_gicp::PointCloud>();
  target->points = Homogeneous(Read(folder + "/target.bin"), 1.0);
  target->normals = Homogeneous(Read(folder + "/target_n.bin"), 0.0);
  source->points = Homogeneous(Read(folder + "/source.bin"), 1.0);
  const std::vector<double> pose = Read(folder + "/T_true.bin");
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.data());
  truth.translation() = Eigen::Map<const Eigen::Vector3d>(pose.data() + 9);
  using Tree = small_gicp::KdTree<small_gicp::PointCloud>;
  small_gicp::Registration<PlaneFactor, small_gicp::ParallelReductionOMP,
                           small_gicp::NullFactor, small_gicp::DistanceRejector,
                           small_gicp::GaussNewtonOptimizer>
      registration;
  registration.reduction.num_threads = threads;
  registration.rejector.max_dist_sq = distance_mm * distance_mm;
  registration.criteria.rotation_eps = 0.01 * step_mm;
  registration.criteria.translation_eps = step_mm;
  registration.optimizer.max_iterations = 100;
  for (int run = 0; run < runs; ++run) {
    const std::clock_t cpu_begun = std::clock();
    const auto begun = std::chrono::steady_clock::now();
    const Tree tree(target, small_gicp::KdTreeBuilderOMP(threads));
    const double build_s = Since(begun);
    const auto found = registration.align(*target, *source, tree, Eigen::Isometry3d::Identity());
    const double wall_s = Since(begun);
    const double cpu_s = static_cast<double>(std::clock() - cpu_begun) / CLOCKS_PER_SEC;
    double error_mm = 0.0;
    for (const auto& point : source->points) {
      error_mm = std::max(error_mm, (found.T_target_source * point - truth * point).norm());
    }
    std::printf(
        "{\"wall_s\":%.6f,\"cpu_s\":%.6f,\"build_s\":%.6f,\"error_um\":%.4f,\"converged\":%s}\n",
        wall_s, cpu_s, build_s, 1e3 * error_mm, found.converged ? "true" : "false");
  }
  return 0;
}
