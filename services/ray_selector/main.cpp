// ray_selector: LASER -> CRITICAL_RAYS. Keeps the measurements of each scan and says which of them are critical.

#include "common/scan/ray_selection.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/scan_queue.hpp"
#include "services/runtime/service.hpp"

namespace crsm {
namespace {

class RaySelector {
 public:
  explicit RaySelector(const CommandLine& command_line)
      : parameters_(command_line.parameters()), service_(command_line), scans_(service_.counters()) {
    service_.bus().Subscribe<bot_core::planar_lidar_t>(
        kLaserChannel, [this](const bot_core::planar_lidar_t& message) { scans_.Push(FromMessage(message)); });
  }

  void Run() {
    service_.Run([this] {
      if (scans_.empty()) return true;
      Answer(scans_.front());
      scans_.Pop();
      return scans_.empty();
    });
  }

 private:
  void Answer(const LaserScan& scan) {
    const auto start = Clock::now();
    if (last_answer_ && last_answer_->utime == scan.utime) {
      service_.counters().Add("resent");
    } else {
      Select(scan);
    }
    service_.bus().Publish(kCriticalRaysChannel, *last_answer_);
    service_.RecordLatency(start);
  }

  void Select(const LaserScan& scan) {
    const ValidRays rays = FindValidRays(scan, parameters_.scan);
    const RaySelection selection = SelectRays(rays, parameters_.selection, density_scale_);
    density_scale_ = NextDensityScale(density_scale_, selection.critical.size(), parameters_.selection);
    last_answer_ = ToMessage(scan.utime, rays, selection);
    service_.counters().Add("handled");
    if (rays.size() == 0) service_.counters().Add("scan_without_rays");
    service_.SetState("selecting");
  }

  const Parameters& parameters_;
  Service service_;
  ScanQueue<LaserScan> scans_;
  double density_scale_ = kFirstDensityScale;
  std::optional<critical_rays_t> last_answer_;  ///< sent once more when its scan comes once more
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  using enum crsm::ParameterGroup;
  crsm::CommandLine command_line("ray_selector", "Picks the critical rays of each scan: LASER -> CRITICAL_RAYS.",
                                 {kScan, kSelection}, {"lcm_url", "channel_prefix"});
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::RaySelector(command_line).Run(); });
}
