# The page of `bgsim report`: cli/web's style and script and the plotting library uPlot, as text in a generated source
# (web_assets). uPlot comes from npm at the version and with the hash in cli/web/package-lock.json; npm takes the
# registry that it is set to. Without npm or network: -DBGSIM_UPLOT_DIR=FOLDER, uPlot's unpacked package. With neither
# all is built but the page: bgsim report says so then.
set(BGSIM_UPLOT_DIR "" CACHE PATH "uPlot's unpacked package (dist/, LICENSE, package.json); empty: npm fetches it")
set(web_sources ${CMAKE_CURRENT_SOURCE_DIR}/cli/web)
set(web_folder ${CMAKE_CURRENT_BINARY_DIR}/web)
set(web_inputs package.json package-lock.json .npmrc report.css report.js report_files.js report_lanes.js report_phase.js assets.cpp.in)
list(TRANSFORM web_inputs PREPEND ${web_sources}/)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${web_inputs})

file(READ ${web_sources}/package-lock.json web_lock)
string(JSON uplot_version GET "${web_lock}" packages node_modules/uplot version)

# Installs what the lock names into web_folder, unless it is there already. Warns where that fails.
function(fetch_uplot)
  file(SHA256 ${web_sources}/package-lock.json lock_hash)
  set(done ${web_folder}/installed-${lock_hash})
  if(EXISTS ${done})
    return()
  endif()
  set(way_out "or give the unpacked package of uPlot ${uplot_version} as -DBGSIM_UPLOT_DIR=FOLDER, then configure again")
  find_program(NPM npm)
  mark_as_advanced(NPM)
  if(NOT NPM)
    message(WARNING "bgsim is built without uPlot, hence without bgsim report: fetching it takes npm, and there is none. "
                    "Install it (Debian: apt-get install npm), ${way_out}")
    return()
  endif()
  file(REMOVE_RECURSE ${web_folder})
  file(COPY ${web_sources}/package.json ${web_sources}/package-lock.json ${web_sources}/.npmrc DESTINATION ${web_folder})
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --no-update-notifier
                  WORKING_DIRECTORY ${web_folder} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(WARNING "bgsim is built without uPlot, hence without bgsim report: npm could not fetch ${uplot_version}; is "
                    "there a network? Mend that, ${way_out}. What npm said:\n${output}")
    return()
  endif()
  file(TOUCH ${done})
endfunction()

if(BGSIM_UPLOT_DIR)
  set(uplot ${BGSIM_UPLOT_DIR})
  if(NOT EXISTS ${uplot}/package.json)
    message(FATAL_ERROR "BGSIM_UPLOT_DIR: there is no package.json in ${uplot}")
  endif()
  file(READ ${uplot}/package.json uplot_package)
  string(JSON given_version GET "${uplot_package}" version)
  if(NOT given_version STREQUAL uplot_version)
    message(FATAL_ERROR "BGSIM_UPLOT_DIR holds uPlot ${given_version}; bgsim's report page is made for ${uplot_version}")
  endif()
else()
  fetch_uplot()
  set(uplot ${web_folder}/node_modules/uplot)
endif()

if(EXISTS ${uplot}/package.json)
  file(READ ${uplot}/dist/uPlot.min.css uplot_style)
  file(READ ${uplot}/dist/uPlot.iife.min.js uplot_script)
  file(READ ${uplot}/LICENSE uplot_license)
endif()
file(READ ${web_sources}/report.css page_style)
file(READ ${web_sources}/report.js page_script)
foreach(part report_files.js report_lanes.js report_phase.js) # one closure, several files
  file(READ ${web_sources}/${part} part_script)
  string(REPLACE "  //@include ${part}\n" "${part_script}" page_script "${page_script}")
endforeach()
configure_file(${web_sources}/assets.cpp.in ${web_folder}/assets.cpp @ONLY)

add_library(web_assets OBJECT ${web_folder}/assets.cpp)
target_include_directories(web_assets PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/cli)
