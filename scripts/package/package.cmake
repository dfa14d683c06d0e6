# Debian packages by component, for scripts/package/make: what they are called, say and need, and files that only
# packages have.
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL gateway lab python dev doc)
if(ARKMESH_CAMERAS)
  list(APPEND CPACK_COMPONENTS_ALL testbed)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGE_NAME arkmesh)
# Each Debian has packages of its own, and those of a newer one take the place of an older one's.
cmake_host_system_information(RESULT debian QUERY DISTRIB_VERSION_ID)
cmake_host_system_information(RESULT suite QUERY DISTRIB_VERSION_CODENAME)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION}~deb${debian})
set(CPACK_ARKMESH_SUITE ${suite})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/package)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/finish.cmake)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
  WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
# Who CITATION.cff names. There is no address that somebody reads; Debian wants one, of a host that there is.
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "The arkmesh authors <arkmesh@users.noreply.github.com>")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(same "(= ${CPACK_PACKAGE_VERSION})")

# debian_package(COMPONENT NAME SECTION SUMMARY TEXT [DEPENDS ...] [RECOMMENDS ...] [CONTROL ...]):
# TEXT is the description below the summary.
macro(debian_package component name section summary text)
  cmake_parse_arguments(DEB "" "" "DEPENDS;RECOMMENDS;SUGGESTS;CONTROL" ${ARGN})
  string(TOUPPER ${component} upper)
  string(REPLACE ";" ", " DEB_DEPENDS "${DEB_DEPENDS}")
  string(REPLACE ";" ", " DEB_RECOMMENDS "${DEB_RECOMMENDS}")
  string(REPLACE ";" ", " DEB_SUGGESTS "${DEB_SUGGESTS}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${DEB_DEPENDS}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_RECOMMENDS "${DEB_RECOMMENDS}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_SUGGESTS "${DEB_SUGGESTS}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA "${DEB_CONTROL}")
endmacro()

debian_package(gateway arkmesh-gateway science "joins a robot-swarm lab with others over TCP"
  "arkmesh joins robot-swarm labs into one shared world. This package has the
gateway, which joins the message bus of a lab with those of other labs, the
lab's keys, and the commands that show and stop a lab. It needs neither
simulator nor cameras, and suits a small computer at the door of a lab's
network."
  DEPENDS "systemd | systemd-standalone-sysusers"
  SUGGESTS polkitd sudo
  CONTROL ${CMAKE_CURRENT_LIST_DIR}/gateway/postinst ${CMAKE_CURRENT_LIST_DIR}/gateway/prerm
    ${CMAKE_CURRENT_LIST_DIR}/gateway/conffiles)
debian_package(lab arkmesh science "simulated Kilobot labs that share one world"
  "arkmesh joins robot-swarm labs into one shared world. This package runs labs
with simulated Kilobots: one or several in a process, batches of runs,
recordings and their figures, and a live page for browsers. The shipped
experiments have their robots' programs compiled; a program of your own
takes gcc."
  DEPENDS "arkmesh-gateway ${same}" python3
  RECOMMENDS "python3-arkmesh ${same}" gcc libc6-dev liblcm-bin python3-matplotlib python3-numpy python3-pil
    python3-h5py
  SUGGESTS arkmesh-doc arkmesh-testbed ffmpeg chromium chromium-driver python3-selenium gcc-avr avr-libc
  CONTROL ${CMAKE_CURRENT_LIST_DIR}/lab/postinst ${CMAKE_CURRENT_LIST_DIR}/lab/prerm)
debian_package(testbed arkmesh-testbed science "labs with real Kilobots: cameras and overhead controller"
  "arkmesh joins robot-swarm labs into one shared world. This package tracks
real Kilobots with cameras and drives their overhead controller. It also has
an emulated testbed, and the program that tells robots to stand when their
lab is gone."
  DEPENDS "arkmesh ${same}"
  RECOMMENDS ffmpeg
  CONTROL ${CMAKE_CURRENT_LIST_DIR}/testbed/postinst)
debian_package(python python3-arkmesh python "scenarios, runs and recordings of arkmesh in Python"
  "arkmesh joins robot-swarm labs into one shared world. This package lets an
experiment be one file in Python, runs labs from scripts and notebooks, and
reads recorded runs as arrays of numpy."
  DEPENDS python3:any python3-numpy
  RECOMMENDS "arkmesh ${same}"
  CONTROL ${CMAKE_CURRENT_LIST_DIR}/python/postinst ${CMAKE_CURRENT_LIST_DIR}/python/prerm)
debian_package(dev libarkmesh-dev libdevel "scenarios of arkmesh in C++"
  "arkmesh joins robot-swarm labs into one shared world. This package has
headers, static libraries and the CMake package with which programs with
scenarios of your own are built and tested. The command `arkmesh scenario
new NAME --cpp` begins one."
  DEPENDS "arkmesh ${same}" cmake g++ make pkg-config liblcm-dev libglib2.0-dev libode-dev libboost-dev
    libssl-dev libzstd-dev libopencv-dev libavcodec-dev libavformat-dev libavutil-dev libswscale-dev libjpeg-dev libeigen3-dev libserialport-dev libnats-dev libsodium-dev zlib1g-dev libfmt-dev
    libspdlog-dev libcli11-dev nlohmann-json3-dev libtomlplusplus-dev
  RECOMMENDS "arkmesh-testbed ${same}")
debian_package(doc arkmesh-doc doc "documents of arkmesh"
  "arkmesh joins robot-swarm labs into one shared world. This package has its
documents as pages with a search, for a browser: courses, a page for each
task, keys, commands, messages and counters, and what was measured. They
begin at /usr/share/doc/arkmesh/html/index.html.")

# Programs and libraries need what dpkg-shlibdeps finds.
foreach(component GATEWAY LAB TESTBED)
  set(CPACK_DEBIAN_${component}_PACKAGE_SHLIBDEPS ON)
endforeach()
foreach(component PYTHON DOC)
  set(CPACK_DEBIAN_${component}_PACKAGE_ARCHITECTURE all)
endforeach()

install(PROGRAMS scripts/package/gateway/still_old DESTINATION lib/arkmesh COMPONENT gateway EXCLUDE_FROM_ALL)
set(units lib/systemd/system)
install(FILES scripts/package/gateway/arkmesh-gateway@.service DESTINATION ${units} COMPONENT gateway EXCLUDE_FROM_ALL)
install(FILES scripts/package/lab/arkmesh-lab@.service DESTINATION ${units} COMPONENT lab EXCLUDE_FROM_ALL)
install(FILES scripts/package/gateway/sysusers.conf RENAME arkmesh.conf DESTINATION lib/sysusers.d
  COMPONENT gateway EXCLUDE_FROM_ALL)
install(FILES scripts/package/gateway/arkmesh.rules DESTINATION share/polkit-1/rules.d
  COMPONENT gateway EXCLUDE_FROM_ALL)
# Man pages and completions, where scripts/package/make has made them.
foreach(component gateway lab testbed)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/pages/${component}/ DESTINATION share
    COMPONENT ${component} OPTIONAL EXCLUDE_FROM_ALL)
endforeach()
# The documentation site, likewise.
install(DIRECTORY ${PROJECT_BINARY_DIR}/site/ DESTINATION share/doc/arkmesh/html COMPONENT doc OPTIONAL EXCLUDE_FROM_ALL)
install(FILES CHANGELOG.md DESTINATION share/doc/arkmesh COMPONENT doc EXCLUDE_FROM_ALL)
include(CPack)
