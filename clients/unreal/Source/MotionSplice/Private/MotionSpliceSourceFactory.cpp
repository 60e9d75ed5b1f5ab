#include "MotionSpliceSourceFactory.h"

#include "MotionSpliceSource.h"

#define LOCTEXT_NAMESPACE "MotionSplice"

FText UMotionSpliceSourceFactory::GetSourceDisplayName() const
{
	return LOCTEXT("SourceName", "motionsplice");
}

FText UMotionSpliceSourceFactory::GetSourceTooltip() const
{
	return LOCTEXT("SourceTooltip", "Splices the upper body of one clip of a bank onto the lower body of another");
}

TSharedPtr<ILiveLinkSource> UMotionSpliceSourceFactory::CreateSource(const FString&) const
{
	return MakeShared<FMotionSpliceSource>();
}

#undef LOCTEXT_NAMESPACE
