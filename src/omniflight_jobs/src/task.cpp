#include "omniflight_jobs/task.hpp"

#include <fmt/format.h>

#include <charconv>
#include <iostream>
#include <nlohmann/json.hpp>

#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::jobs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kSchema = "omniflight.job_array/1";
constexpr std::size_t kLargest = 256 * files::kMegabyte;

fs::path failures(const fs::path& file) { return file.string() + ".failed"; }

}  // namespace

Status write_array(const JobArray& array, const fs::path& file) {
  json j{{"schema", kSchema}, {"program", array.program}, {"tasks", array.tasks}, {"jobs", json::array()}};
  for (const Job& job : array.jobs)
    j["jobs"].push_back({{"name", job.name},
                         {"folder", job.folder.string()},
                         {"command", job.command},
                         {"results", job.results}});
  return files::write_file_atomic(file, j.dump() + "\n");
}

Result<JobArray> read_array(const fs::path& file) {
  auto text = files::read_file(file, kLargest);
  if (!text) return Failure(text.error());
  const json j = json::parse(*text, nullptr, false);
  const auto damaged = [&](const std::string& field) {
    return bad_input("is no job array: " + field, file.string(), "Start the campaign again with --resume");
  };
  if (!j.is_object() || j.value("schema", json()) != kSchema) return damaged("schema");
  JobArray out;
  try {  // the library reports a wrong type by an exception
    out.program = j.at("program").get<std::string>();
    out.tasks = j.at("tasks").get<std::vector<std::vector<std::size_t>>>();
    for (const json& one : j.at("jobs"))
      out.jobs.push_back({one.at("name").get<std::string>(), one.at("folder").get<std::string>(),
                          one.at("command").get<std::vector<std::string>>(),
                          one.at("results").get<std::vector<int>>()});
  } catch (const json::exception& e) {
    return damaged(e.what());
  }
  for (const auto& task : out.tasks)
    for (const std::size_t k : task)
      if (k >= out.jobs.size()) return damaged(fmt::format("tasks name job {} of {}", k, out.jobs.size()));
  for (const Job& job : out.jobs)
    if (!job.folder.is_absolute()) return damaged("jobs: the folder of " + files::shown(job.name));
  return out;
}

Result<int> run_task(const fs::path& file, std::size_t number, bool (*stop)()) {
  auto array = read_array(file);
  if (!array) return Failure(array.error());
  if (number >= array->tasks.size())
    return bad_input(fmt::format("there is no task {} of {}", number, array->tasks.size()), file.string());
  bool all = true;
  for (const std::size_t k : array->tasks[number]) {
    const Job& job = array->jobs[k];
    const Performed done = perform(job, array->program, stop);
    if (done.ending == Ending::stopped) return static_cast<int>(ErrorCode::incomplete);
    if (done.ending == Ending::done || done.ending == Ending::done_before) continue;
    all = false;
    std::cerr << job.name << " " << done.reason << std::endl;
    std::error_code ec;
    fs::create_directories(failures(file), ec);
    (void)files::write_file_atomic(
        failures(file) / (job.name + ".json"),
        json{{"name", job.name}, {"reason", done.reason}, {"killed", done.ending == Ending::killed}}.dump() +
            "\n");
  }
  return all ? 0 : static_cast<int>(ErrorCode::incomplete);
}

int run_task_main(const std::string& file, const std::string& number) {
  install_interrupt_handler();
  std::size_t task = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), task);
  const auto result = error == std::errc() && end == number.data() + number.size()
                          ? run_task(file, task, interrupted)
                          : Result<int>(bad_input("is no number of a task", files::shown(number)));
  if (result) return *result;
  std::cerr << "run-task: " << result.error().text() << std::endl;
  return static_cast<int>(result.error().code);
}

std::optional<TaskFailure> failure_of(const Job& job, const fs::path& file) {
  const auto text = files::read_file(failures(file) / (job.name + ".json"), files::kMegabyte);
  if (!text) return std::nullopt;
  const json j = json::parse(*text, nullptr, false);
  if (!j.is_object() || !j.contains("reason") || !j["reason"].is_string() || !j.contains("killed") ||
      !j["killed"].is_boolean())
    return TaskFailure{"left an unreadable reason", true};
  return TaskFailure{j["reason"].get<std::string>(), j["killed"].get<bool>()};
}

}  // namespace omniflight::jobs
