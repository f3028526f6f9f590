#include "session.h"

#include <csignal>

#include <vtkInitializationHelper.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkProcessModule.h>
#include <vtkSMParaViewPipelineController.h>
#include <vtkSMProxyManager.h>
#include <vtkSMSession.h>
#include <vtkSMSessionProxyManager.h>

namespace
{
// ParaView takes these for itself and prints stack traces; the engine decides what they mean.
class signals_kept
{
  public:
	signals_kept()
	{
		for (int s = 1; s < COUNT; s++)
			sigaction(s, nullptr, &before[s]);
	}
	~signals_kept()
	{
		for (int s = 1; s < COUNT; s++)
			sigaction(s, &before[s], nullptr);
	}

  private:
	static constexpr int COUNT = 32;
	struct sigaction before[COUNT];
};
// With what scripts expect of one: a time keeper, selections.
void open_session(vtkSMProxyManager *manager)
{
	manager->SetActiveSession(vtkSMSession::ConnectToSelf());
	vtkNew<vtkSMParaViewPipelineController> controller;
	if (manager->GetActiveSession())
		controller->InitializeSession(manager->GetActiveSession());
}
} // namespace

vtkSMSessionProxyManager *session_start(std::string &error)
{
	signals_kept kept;
	char name[] = "tmdempm-viewer", alone[] = "--no-mpi", *arguments[] = {name, alone, nullptr};
	vtkInitializationHelper::SetApplicationName(name);
	vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_ERROR); // ParaView warns of what is so by intention
	if (!vtkProcessModule::GetProcessModule() &&
		!vtkInitializationHelper::Initialize(2, arguments, vtkProcessModule::PROCESS_BATCH)) {
		error = "ParaView does not start";
		return nullptr;
	}
	vtkSMProxyManager *manager = vtkSMProxyManager::GetProxyManager();
	if (!manager->GetActiveSessionProxyManager())
		open_session(manager);
	if (!manager->GetActiveSessionProxyManager())
		error = "ParaView opens no session";
	return manager->GetActiveSessionProxyManager();
}
