# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts on a machine. debian/rules takes only the programs and profiles from here, because debhelper
# installs the rest itself. /etc/mbgate is never written: the configuration belongs to the administrator.
option(MBGATE_INSTALL_SYSTEM "Install systemd units, accounts, manual pages and completion too" ON)

install(TARGETS mbgated mbgate-signer RUNTIME DESTINATION ${CMAKE_INSTALL_SBINDIR})
install(TARGETS mbgatectl mbgate-sim RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(PROGRAMS tools/mbgate-cert DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY conf/profiles/ DESTINATION ${CMAKE_INSTALL_DATADIR}/mbgate/profiles)

if(NOT MBGATE_INSTALL_SYSTEM)
  return()
endif()

function(mbgate_install_system folder)
  install(FILES ${ARGN} DESTINATION ${folder} COMPONENT system)
endfunction()

# systemd looks below /usr/local as well as below /usr, in `lib` whatever the processor. The units name the programs by
# their full paths.
foreach(unit IN ITEMS mbgated.service mbgated.socket mbgated-http.socket mbgate-signer.service mbgate-signer.socket)
  file(READ ${PROJECT_SOURCE_DIR}/systemd/${unit} text)
  string(REPLACE /usr/sbin/mbgate ${CMAKE_INSTALL_FULL_SBINDIR}/mbgate text "${text}")
  string(REPLACE /usr/bin/mbgate ${CMAKE_INSTALL_FULL_BINDIR}/mbgate text "${text}")
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/systemd/${unit} "${text}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS systemd/${unit})
  mbgate_install_system(lib/systemd/system ${CMAKE_CURRENT_BINARY_DIR}/systemd/${unit})
endforeach()
mbgate_install_system(lib/systemd/catalog systemd/mbgate.catalog)
install(FILES debian/mbgate.sysusers DESTINATION lib/sysusers.d RENAME mbgate.conf COMPONENT system)

foreach(section IN ITEMS 1 5 8)
  file(GLOB pages CONFIGURE_DEPENDS debian/man/*.${section})
  mbgate_install_system(${CMAKE_INSTALL_MANDIR}/man${section} ${pages})
endforeach()
mbgate_install_system(${CMAKE_INSTALL_DOCDIR} conf/mbgate.toml)

foreach(program IN ITEMS mbgated mbgatectl mbgate-cert mbgate-sim mbgate-bench)
  install(FILES debian/completion/bash/mbgated DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    RENAME ${program} COMPONENT system)
endforeach()
mbgate_install_system(${CMAKE_INSTALL_DATADIR}/zsh/site-functions debian/completion/zsh/_mbgated)
