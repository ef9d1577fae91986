// What the verbs that have an executor share.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "campaign_run.hpp"
#include "omniflight_core/progress.hpp"

namespace omniflight::cli {

namespace fs = std::filesystem;

std::string this_program() {
  std::error_code ec;
  return fs::read_symlink("/proc/self/exe", ec).string();
}

jobs::Work work_of(const std::string& out, std::vector<jobs::Job> list, const Common& common,
                   std::function<void(std::size_t)> progress) {
  jobs::Work work;
  work.jobs = std::move(list);
  work.program = this_program();
  work.run_task = {"run-task"};
  work.folder = fs::absolute(out).lexically_normal() / ".jobs";
  work.stop = interrupted;
  work.progress = std::move(progress);
  work.say = [&common](const std::string& line) { say(common, line); };
  return work;
}

Result<FlightResult> fly_as_job(const FlightOptions& options, const std::string& name) {
  auto result = fly(options);
  if (!interrupted()) return result;
  std::error_code ec;
  fs::remove_all(options.out, ec);
  return fail(ErrorCode::incomplete, "interrupted", name);
}

Status clear_away(const std::string& folder) {
  std::error_code ec;
  if (!fs::exists(fs::symlink_status(folder, ec))) return {};
  // renamed first: whoever is killed in between leaves no half of a result under its name
  const fs::path path = fs::absolute(folder).lexically_normal();
  const std::string aside =
      (path.parent_path() / fmt::format(".old-{}-{}", getpid(), path.filename().string())).string();
  fs::rename(folder, aside, ec);
  if (ec) return bad_input("cannot be replaced: " + ec.message(), folder, "Choose another --out");
  fs::remove_all(aside, ec);
  return {};
}

void say_executor(const Common& common, const jobs::Ran& ran) {
  if (ran.arrays > 0)
    say(common, fmt::format("cluster: {} array{}, {} task{} begun again by the cluster; submission {:.1f} s, "
                            "work {:.1f} s, collection {:.1f} s",
                            ran.arrays, ran.arrays == 1 ? "" : "s", ran.requeued,
                            ran.requeued == 1 ? "" : "s", ran.submit_s, ran.work_s, ran.collect_s));
  for (const std::string& remark : ran.remarks) say(common, "  " + remark);
}

nlohmann::json to_json(const jobs::Ran& ran, const jobs::ExecutorOptions& options) {
  return {{"name", options.name},          {"results_before", ran.before}, {"results_made", ran.made},
          {"missing", ran.missing.size()}, {"arrays", ran.arrays},         {"requeued", ran.requeued},
          {"submit_s", ran.submit_s},      {"work_s", ran.work_s},         {"collect_s", ran.collect_s},
          {"remarks", ran.remarks}};
}

}  // namespace omniflight::cli
