# Makes colour_table.hpp, for hal/overlay/colour.hpp, from view/page/colours.json. A wrong table ends the configuration with a sentence.
set(table ${PROJECT_SOURCE_DIR}/view/page/colours.json)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${table})
file(READ ${table} json)
set(rows "")
string(JSON last LENGTH "${json}" colours)
math(EXPR last "${last} - 1")
foreach(i RANGE ${last})
  string(JSON name MEMBER "${json}" colours ${i})
  string(JSON light GET "${json}" colours ${name} light)
  string(JSON dark GET "${json}" colours ${name} dark)
  string(JSON pattern GET "${json}" colours ${name} pattern)
  if(NOT "${name} ${light} ${dark} ${pattern}" MATCHES
      "^[a-z]+(_[a-z]+)* #[0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f] #[0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f] (plain|stripes|dots|cross)$")
    message(FATAL_ERROR "${table}: colour ${name}: `light` and `dark` are #rrggbb in small letters; `pattern` is plain, stripes, dots or cross")
  endif()
  string(REPLACE "#" "0x" look "${light}, ${dark}, ${pattern}")
  string(APPEND rows " \\\n  X(${name}, ${look})")
endforeach()
string(JSON fill_opacity GET "${json}" fill_opacity)
string(JSON raster_opacity GET "${json}" raster_opacity)
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/generated/colour_table.hpp CONTENT [[// Made from view/page/colours.json.
#pragma once

#define ARKMESH_COLOURS(X)@rows@
#define ARKMESH_FILL_OPACITY @fill_opacity@
#define ARKMESH_RASTER_OPACITY @raster_opacity@
]] @ONLY)
target_include_directories(arkmesh_hal PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_BINARY_DIR}/generated>)
