// A Live Link source that evaluates a splice and pushes its frames.
#pragma once

#include <atomic>

#include "CoreMinimal.h"
#include "HAL/CriticalSection.h"
#include "HAL/Event.h"
#include "HAL/Runnable.h"
#include "ILiveLinkSource.h"
#include "MotionSpliceSourceSettings.h"
#include "Templates/UniquePtr.h"

class FMotionSpliceCharacter;
class FRunnableThread;

/**
 * Frames come from a thread of its own, not from Update, which Live Link calls once for each rendered frame. So a bank
 * may take seconds to read, and frames stay evenly spaced in time however long rendering takes. Live Link interpolates
 * between them for the moment that it shows.
 */
class FMotionSpliceSource final : public ILiveLinkSource, private FRunnable
{
public:
	FMotionSpliceSource();
	virtual ~FMotionSpliceSource() override;

	virtual void ReceiveClient(ILiveLinkClient* InClient, FGuid InSourceGuid) override;
	virtual void InitializeSettings(ULiveLinkSourceSettings* Settings) override;
	virtual void OnSettingsChanged(ULiveLinkSourceSettings* Settings, const FPropertyChangedEvent& Event) override;
	virtual TSubclassOf<ULiveLinkSourceSettings> GetSettingsClass() const override;
	virtual bool IsSourceStillValid() const override { return bPlaying; }
	virtual bool RequestSourceShutdown() override;
	virtual FText GetSourceType() const override;
	virtual FText GetSourceMachineName() const override;
	virtual FText GetSourceStatus() const override;

private:
	virtual uint32 Run() override;
	virtual void Stop() override;

	/** Hands the settings over to the thread. */
	void Request(const ULiveLinkSourceSettings* Settings);
	/** Makes the requested settings the current ones. Returns an error message, or an empty string. */
	FString Apply(const FMotionSplicePlayback& Next);
	void PushBones() const;
	/** Pushes the frame of a moment in seconds. Returns an error message, or an empty string. */
	FString PushFrame(double Moment) const;
	void Report(const FString& Error);

	ILiveLinkClient* Client = nullptr;
	FGuid SourceGuid;

	mutable FCriticalSection Lock; // of the three below
	FMotionSplicePlayback Requested;
	bool bRequested = false;
	FText Status;

	// of the thread
	FMotionSplicePlayback Playback;
	TUniquePtr<FMotionSpliceCharacter> Character;

	std::atomic<bool> bPlaying{false}, bStopping{false}, bFinished{true};
	FEventRef Wake;
	TUniquePtr<FRunnableThread> Thread;
};
