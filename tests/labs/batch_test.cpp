// The table of a batch, from results of seeds as runs write them.
#include "app/batch.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/processes/process.hpp"

using namespace arkmesh;

TEST_CASE("a batch's table has a column for every count of any seed and no wall time") {
  // Seed 2 is not there yet, seed 3 has other counts than seed 1 and a reason with commas.
  const tests::TemporaryFolder folder;
  const auto result = [&](int seed, const std::string& json) {
    const auto run = folder.path() / ("seed-" + std::to_string(seed));
    std::filesystem::create_directory(run);
    std::ofstream(run / "result.json") << json;
  };
  const app::Batch batch({{ARKMESH_SOURCE_DIR "/experiments/dhtf/shark.toml"}, {}}, 1, 3, 1, folder.path(), false);
  result(1, R"({"ended": "finished", "final_hash": "11", "counts": {"completed": 7}, "wall": {"speed": 3.5}})");
  batch.save_table();
  CHECK(tests::read_file(batch.table()) == "seed,ended,final_hash,completed\n1,finished,11,7\n");
  result(3, R"({"ended": "a, \"b\"", "final_hash": "33", "counts": {"lapsed": 2, "asked": 1}, "wall": {"speed": 4}})");
  batch.save_table();
  CHECK(tests::read_file(batch.table()) ==
        "seed,ended,final_hash,asked,completed,lapsed\n1,finished,11,0,7,0\n3,\"a, \"\"b\"\"\",33,1,0,2\n");
}
