#include "testbed/kilobot_row.hpp"

#include <algorithm>
#include <iterator>

#include "hal/exit_code.hpp"
#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"
#include "testbed/arena_monitor.hpp"
#include "testbed/arena_video.hpp"
#include "testbed/kilobot_settings.hpp"
#include "testbed/recorded_devices.hpp"
#include "testbed/tracks.hpp"

namespace arkmesh::testbed {
namespace {

std::unique_ptr<hal::Arena> make(const hal::Section& arena, const hal::ArenaRequest& request) {
  const hal::Section kilobot = arena.section("kilobot");
  const KilobotSettings settings = read_kilobot_settings(arena, request.lab);
  const std::shared_ptr<RawRecord> record = make_record(kilobot, settings, request.lab, "kilobot", true);
  const auto guard = std::make_shared<hal::kilobot::StandGuard>(settings.arena.port, request.hung_after);
  std::unique_ptr<hal::kilobot::ByteStream> stream;
  try {
    stream = recorded(hal::kilobot::open_byte_stream(settings.arena.port, request.lab, guard), record);
  } catch (const hal::kilobot::PortTaken& error) {
    throw hal::ExitError(hal::Exit::port_taken, error.what());
  } catch (const hal::kilobot::PortError& error) {
    kilobot.refuse("port", error.what());
  }
  auto names = request.set_up ? std::make_unique<UnnamedTracks>() : nullptr;
  UnnamedTracks* const tracks = names.get();
  Observer observer = make_viewers(settings, request);
  if (tracks) observer = tracks->observer(std::move(observer));
  auto eyes = make_arena_monitor(settings, recorded(std::move(observer), record),
                                 recorded(tracker::open_camera, record), std::move(names));
  auto made =
      recorded(hal::kilobot::make_kilobot_arena(settings.arena, std::move(eyes), std::move(stream), guard), record);
  return tracks ? with_tracks(std::move(made), *tracks) : std::move(made);
}

}  // namespace

hal::ArenaRow kilobot_arena_row() {
  return {"kilobot",
          {"kilobot"},
          hal::ArenaRow::Robots::real,
          make,
          [] {
            std::vector<hal::KeyRow> rows = hal::keys_of<hal::kilobot::ArenaSettings>("arena.kilobot");
            std::ranges::move(hal::keys_of<KilobotSettings>("arena.kilobot"), std::back_inserter(rows));
            std::ranges::move(hal::kilobot::layout_keys(), std::back_inserter(rows));
            return rows;
          },
          hal::kilobot::message_period};
}

}  // namespace arkmesh::testbed
