# Run by CPack once a package's files are in place and before they are packed: Debian's rules for
# every package, and the same bytes from every build.
set(time $ENV{SOURCE_DATE_EPOCH})
if(NOT time)
  message(FATAL_ERROR "SOURCE_DATE_EPOCH is not set; make packages by scripts/package")
endif()

function(compress file)
  execute_process(COMMAND gzip --best --no-name ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Debian's changelog has only the version; the news are in a separate file.
function(write_changelog package folder)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH
  file(WRITE ${folder}/changelog
    "${package} (${CPACK_PACKAGE_VERSION}) bookworm; urgency=medium\n\n"
    "  * Version ${CPACK_PACKAGE_VERSION}; what is new says NEWS.gz of the package kirireel.\n\n"
    " -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  compress(${folder}/changelog)
endfunction()

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(root ${CPACK_TEMPORARY_DIRECTORY}/${component})
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(folder ${root}/usr/share/doc/${package})
  file(MAKE_DIRECTORY ${folder})
  file(COPY ${CPACK_KIRIREEL_COPYRIGHT} DESTINATION ${folder})
  write_changelog(${package} ${folder})
  if(component STREQUAL program)
    configure_file(${CPACK_KIRIREEL_NEWS} ${folder}/NEWS COPYONLY)
    compress(${folder}/NEWS)
  endif()
  file(GLOB pages ${root}/usr/share/man/man*/*.[1-9])
  foreach(page IN LISTS pages)
    compress(${page})
  endforeach()
  # Modes and times as of every build, not of this machine's umask and clock.
  execute_process(COMMAND chmod -R u+rwX,go+rX,go-w ${root} COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND find ${root} -exec touch --no-dereference --date=@${time} {} +
    COMMAND_ERROR_IS_FATAL ANY)
endforeach()
