// What the configuration called otherwise before: keys, sections and values, each with its name of today. A file that
// still has an old one is refused with the new one.
#pragma once

namespace arkmesh::hal {

// Dotted paths; all below a section moves with it. The longest that fits counts.
struct RenamedKey {
  const char* before;
  const char* now;
};

inline constexpr RenamedKey renamed_keys[] = {
    {"room", "emulator"},
    {"room.camera", "emulator.camera"},
    {"room.event", "emulator.event"},
    {"room.scene", "emulator.scene"},
    {"room.scene.table_grey", "emulator.scene.arena_grey"},
    {"emulator.scene.table_grey", "emulator.scene.arena_grey"},
    {"arena.room", "arena.emulated"},
    {"arena.kilobot.window", "the lab's page, whose URL the lab prints; leave this key out"},
    {"arena.kilobot.window_port", "view.port, that of the lab's page"},
};

struct RenamedValue {
  const char* key;
  const char* before;
  const char* now;
};

inline constexpr RenamedValue renamed_values[] = {
    {"arena.use", "room", "emulated"},
};

}  // namespace arkmesh::hal
