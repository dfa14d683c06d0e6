#include "app/batch/batch_manifest.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "app/batch/plain_json.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

// The same from whatever folder a batch is gone on with.
std::string whole_path(const fs::path& file) {
  return fs::weakly_canonical(fs::absolute(file)).string();
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

nlohmann::json factors_of(const BatchPlan& plan) {
  nlohmann::json out = nlohmann::json::array();
  for (const Factor& factor : plan.factors) {
    nlohmann::json levels = nlohmann::json::array();
    for (const Factor::Level& level : factor.levels) levels.push_back({{"label", level.label}, {"sets", level.sets}});
    out.push_back({{"name", factor.name}, {"levels", levels}});
  }
  return out;
}

// Keys whose value differs from that of the first setting; null for one that is not there.
nlohmann::json changes(const CheckedLab& first, const CheckedLab& lab) {
  nlohmann::json out = nlohmann::json::object();
  for (const auto& [key, value] : lab.settings)
    if (const auto before = first.settings.find(key); before == first.settings.end() || before->second != value)
      out[key] = value;
  for (const auto& [key, value] : first.settings)
    if (!lab.settings.contains(key)) out[key] = nullptr;
  return out;
}

nlohmann::json settings_of(const BatchPlan& plan, const std::vector<std::vector<CheckedLab>>& checked) {
  nlohmann::json out = nlohmann::json::array();
  for (std::size_t i = 0; i < checked.size(); ++i) {
    nlohmann::json setting = {{"labels", plan.labels_of(i)}, {"sets", plan.labs_of(i).sets}};
    for (std::size_t k = 0; k < checked[i].size(); ++k)
      setting["differs_from_first"][checked[i][k].name] = changes(checked.front()[k], checked[i][k]);
    out.push_back(setting);
  }
  return out;
}

// Of the files that a batch was begun with, and those that it needs now.
std::string changed_input(const nlohmann::json& begun, const nlohmann::json& now) {
  for (const auto& [file, hash] : begun.items())
    if (hash != lab::file_hash(file)) return file;
  for (const auto& [file, hash] : now.items())
    if (!begun.contains(file)) return file;
  return {};
}

std::string version_of(const nlohmann::json& manifest) {
  const nlohmann::json& versions = object_in(manifest, "versions");
  return fmt::format("arkmesh {} (commit {}, {})", text_in(manifest, "arkmesh", "?"),
                     text_in(versions, "commit", "?").substr(0, 12), text_in(versions, "build", "?"));
}

}  // namespace

nlohmann::json make_manifest(const BatchFile& batch, const std::vector<std::vector<CheckedLab>>& checked) {
  nlohmann::json out = lab::program_facts();
  const BatchPlan& plan = batch.plan;
  const fs::path& file = batch.experiment;
  out["experiment"] = nullptr;
  if (!file.empty()) out["experiment"] = {{"file", file.filename().string()}, {"text", text_of(file)}};
  for (const std::string& lab : plan.labs.files) out["labs"].push_back(whole_path(lab));
  out["set"] = plan.labs.sets;
  out["factors"] = factors_of(plan);
  out["seeds"] = plan.seeds;
  out["runs"] = plan.runs();
  std::map<std::string, std::string> inputs;
  for (const fs::path& one : batch.files) inputs[whole_path(one)] = lab::file_hash(one);
  for (const auto& setting : checked)
    for (const CheckedLab& lab : setting)
      for (const fs::path& one : lab.inputs)
        if (const auto [entry, is_new] = inputs.try_emplace(whole_path(one)); is_new)
          entry->second = lab::file_hash(one);
  out["inputs"] = inputs;
  for (const CheckedLab& lab : checked.front()) out["effective"][lab.name] = lab.effective;
  out["settings"] = settings_of(plan, checked);
  return out;
}

std::string difference(const nlohmann::json& begun, const nlohmann::json& now, bool only_plan) {
  if (!begun.is_object() || !begun.contains("experiment")) return "it contains no batch manifest";
  if (!only_plan && version_of(begun) != version_of(now))
    return fmt::format("it was started with {}, but this is {}", version_of(begun), version_of(now));
  const nlohmann::json none = nlohmann::json::object();
  // which part of the plan first, since that says more than that a file differs
  for (const auto& [key, name] :
       std::map<std::string, std::string>{{"labs", "other labs"},
                                          {"set", "other settings of all runs ([set], --set)"},
                                          {"factors", "another grid ([choices], [sweep])"},
                                          {"seeds", "other seeds"}})
    if (begun.value(key, none) != now.value(key, none)) return fmt::format("it was started with {}", name);
  if (only_plan) return {};
  if (const std::string file = changed_input(object_in(begun, "inputs"), object_in(now, "inputs")); !file.empty())
    return fmt::format("{} has changed since it was started", file);
  return {};
}

}  // namespace arkmesh::app
