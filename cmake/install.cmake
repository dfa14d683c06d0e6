# What is installed, by component, each a Debian package (scripts/package): `gateway` for a computer that runs no lab; `lab`; `testbed` for cameras;
# `python`, the package arkmesh; and `dev`, what programs with scenarios of somebody's own are built with. Programs are in bin, the files that they take
# along in share/arkmesh. All of it is found from where it lies, so the folder may be moved.
include(CMakePackageConfigHelpers)
set(share share/arkmesh)

install(TARGETS arkmesh arkmesh-gateway DESTINATION bin COMPONENT gateway)
install(TARGETS arkmesh-lab arkmesh-recording DESTINATION bin COMPONENT lab)
# The guard is for labs with real robots.
if(ARKMESH_CAMERAS)
  install(TARGETS arkmesh-testbed arkmesh-guard DESTINATION bin COMPONENT testbed)
else()
  install(TARGETS arkmesh-guard DESTINATION bin COMPONENT lab)
endif()
# What robots' programs are compiled against, and those of the shipped experiments, compiled where somebody asked for them (arkmesh_shipped_programs).
install(DIRECTORY sim_ode/kilolib sim_ode/silicon hal/platforms/kilobot/firmware DESTINATION ${share} COMPONENT lab)
install(DIRECTORY ${PROJECT_BINARY_DIR}/shipped_programs/ DESTINATION lib/arkmesh/programs COMPONENT lab OPTIONAL)
# Experiments lie to their robots' programs as they do among the sources.
install(DIRECTORY experiments DESTINATION ${share} COMPONENT lab PATTERN "__pycache__" EXCLUDE PATTERN "keys" EXCLUDE)
install(DIRECTORY scenarios/dhtf/controller DESTINATION ${share}/scenarios/dhtf COMPONENT lab)
install(DIRECTORY scenarios/cre/controller DESTINATION ${share}/scenarios/cre COMPONENT lab)
# What draws runs.
install(PROGRAMS drawing/draw_swarm drawing/plot_batch drawing/plot drawing/plot_curves drawing/summarise_batch drawing/publish drawing/fit_robots drawing/fit_check scripts/read_log.py drawing/film DESTINATION ${share} COMPONENT lab)
install(FILES drawing/intervals.py drawing/figure_style.py drawing/batch_figure.py drawing/curve_figure.py drawing/run_figure.py drawing/robot_fit.py drawing/robot_tracks.py drawing/draw_overlay.py drawing/replay.html drawing/film_frames.py drawing/film_file.py drawing/painted_film.py drawing/chromium.py scripts/lab_processes.py view/page/colours.json
  DESTINATION ${share} COMPONENT lab)
install(DIRECTORY ${PROJECT_BINARY_DIR}/lcmtypes/python/ DESTINATION ${share}/lcmtypes COMPONENT lab)
# Scenarios in Python, and what `arkmesh scenario new` copies beside the experiment light_up.
install(DIRECTORY scenarios/python DESTINATION ${share} COMPONENT python FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
install(FILES scenarios/light_up/light_up.hpp scenarios/light_up/light_up.cpp DESTINATION ${share}/experiments/light_up/cpp COMPONENT lab)

# Headers: what a scenario includes (lab/scenario.hpp, scenarios/*.hpp, scenarios/kit), its test (lab/testing) and its main() (cli/whole_program.hpp), with what those
# include. A test builds such a program from them alone.
foreach(header
    app/scenarios.hpp cli/whole_program.hpp lab/testing/lab_double.hpp lab/robots/robot_words.hpp scenarios/wall_sensor.hpp
    lab/arena_facts.hpp lab/lab.hpp lab/lab_data.hpp lab/run_config.hpp lab/safety_config.hpp lab/scenario.hpp lab/sensor_config.hpp
    lab/exchange/exchange.hpp lab/exchange/growth.hpp lab/exchange/lab_state.hpp lab/exchange/state_rules.hpp
    hal/arenas/arena.hpp hal/arenas/projection.hpp hal/bus/bus.hpp hal/bus/participants.hpp hal/config/config.hpp hal/counters.hpp
    hal/files/own_files.hpp hal/fixed_math.hpp hal/overlay/colour.hpp hal/overlay/drawing.hpp hal/robot/robot_kind.hpp hal/robot/set_point.hpp hal/random.hpp hal/record/recorder.hpp
    hal/stop_request.hpp hal/time/clock.hpp hal/time/wall_time.hpp hal/types.hpp
    hal/layout/message.hpp hal/layout/types.hpp)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${header} DESTINATION include/arkmesh/${folder} COMPONENT dev)
endforeach()
install(DIRECTORY scenarios/kit DESTINATION include/arkmesh/scenarios COMPONENT dev FILES_MATCHING PATTERN "*.hpp")
install(FILES ${PROJECT_BINARY_DIR}/hal/generated/colour_table.hpp DESTINATION include/arkmesh COMPONENT dev)
install(DIRECTORY ${PROJECT_BINARY_DIR}/lcmtypes/cpp/arkmesh DESTINATION include COMPONENT dev FILES_MATCHING PATTERN "*.hpp")

# Libraries: arkmesh::cli, arkmesh::scenarios and arkmesh::testing, with all that they are linked to.
set(libraries options lcmtypes hal http kilobot aseba sim_ode recording recorded_view gateway lab testing view scenarios doctor app mark
  cli_base cli_light cli_gateway cli)
if(ARKMESH_CAMERAS)
  list(APPEND libraries tracker testbed emulator)
endif()
foreach(library ${libraries})
  set_target_properties(arkmesh_${library} PROPERTIES EXPORT_NAME ${library})
  install(TARGETS arkmesh_${library} EXPORT arkmesh DESTINATION lib/arkmesh COMPONENT dev)
endforeach()
set(package lib/cmake/arkmesh)
install(EXPORT arkmesh NAMESPACE arkmesh:: FILE arkmeshTargets.cmake DESTINATION ${package} COMPONENT dev)
configure_package_config_file(cmake/arkmeshConfig.cmake.in arkmeshConfig.cmake INSTALL_DESTINATION ${package})
# Until 1.0.0 a minor release may change the interface.
write_basic_package_version_file(arkmeshConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/arkmeshConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/arkmeshConfigVersion.cmake DESTINATION ${package} COMPONENT dev)

if(PROJECT_IS_TOP_LEVEL)
  include(scripts/package/package.cmake)
endif()
