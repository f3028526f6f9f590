// ParaView's link, with what it does not tell by itself.
#pragma once

#include <vtkClientSocket.h>
#include <vtkLiveInsituLink.h>
#include <vtkMultiProcessController.h>
#include <vtkObjectFactory.h>
#include <vtkSocketCommunicator.h>
#include <vtkSocketController.h>

class live_link : public vtkLiveInsituLink
{
  public:
	static live_link *New();
	vtkTypeMacro(live_link, vtkLiveInsituLink);

	bool connected() const { return this->Proc0NodesController != nullptr; }

	// Of the socket on which the other side speaks; -1 if it is not known.
	int descriptor() const
	{
		auto *controller = vtkSocketController::SafeDownCast(this->Proc0NodesController);
		auto *communicator =
			controller ? vtkSocketCommunicator::SafeDownCast(controller->GetCommunicator()) : nullptr;
		return communicator && communicator->GetSocket() ? communicator->GetSocket()->GetSocketDescriptor() : -1;
	}

  protected:
	live_link() = default;
	~live_link() override = default;
};
